import pytest
from report_pages import LAW

from setcmas_tools.offline.offline_simulation import simulate
from setcmas_tools.run.run import Run


@pytest.fixture(scope='session')
def failed(tmp_path_factory):
    """The folder of a run whose law fails."""
    law = tmp_path_factory.mktemp('law') / 'law.py'
    law.write_text(LAW)
    run = simulate(str(law), 3, 4.0, graph='ring', delay=0.3, warn=lambda _: None)
    return run.save(tmp_path_factory.mktemp('runs') / 'failed')


@pytest.fixture(scope='session')
def failed_run(failed):
    return Run.load(failed)
