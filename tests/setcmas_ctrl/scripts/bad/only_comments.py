# load: only_comments.py has no function control; it must have
