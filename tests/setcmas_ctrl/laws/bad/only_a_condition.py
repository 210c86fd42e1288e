# load: only_a_condition.py has no function control; its ctc is for --event-triggered --ctc only_a_condition.py; it must have
def ctc(pos, last_pos, t):
    return True
