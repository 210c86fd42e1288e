# load: only_comments.py has no function control; expected is
