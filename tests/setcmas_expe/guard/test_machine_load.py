import pytest

from setcmas_expe.guard.machine_load import ProcessorLoad


@pytest.mark.parametrize(('share', 'overload'), [(0.1, False), (0.6, False), (0.95, True)])
def test_processes_that_wait_most_of_the_time_are_an_overload(tmp_path, share, overload):
    pressure = tmp_path / 'cpu'
    load = ProcessorLoad(pressure)
    load.look(9.0)  # a kernel without it
    for step in range(60):
        now = 10.0 + 0.05 * step
        total = round(1e6 * share * now)
        pressure.write_text(f'some avg10=0.00 avg60=0.00 avg300=0.00 total={total}\nfull x\n')
        load.look(now)

    assert load.is_overload == overload
