from processes import TIMEOUT_S

from launch_scripts.offline.early_start import start_early, started


def test_a_process_without_a_job_ends_with_the_command_that_started_it():
    start_early()
    waiting = started()
    with waiting.process as process:
        process.stdin.close()  # as when the command ends

        assert process.wait(TIMEOUT_S) == 0
        assert process.stdout.read() == process.stderr.read() == b''
    waiting.clean_up()
