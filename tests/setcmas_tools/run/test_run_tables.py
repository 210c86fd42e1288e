import pytest

from setcmas_simu.errors import SetcmasError
from setcmas_tools.run.fleet_motion import fleet_table
from setcmas_tools.run.run_tables import (
    COMMANDS,
    DRAWINGS,
    FLEET,
    RunTables,
    read_fleet,
    read_tables,
    write_tables,
)


@pytest.mark.parametrize('lead', ['', '\ufeff'])
@pytest.mark.parametrize('ending', ['\n', '\r\n'])
def test_files_that_a_spreadsheet_has_saved(tmp_path, lead, ending):
    path = tmp_path / 'fleet.csv'
    path.write_bytes(f'{lead}{FLEET.header}{ending}0,1,1,2,3,4,5{ending}'.encode())

    assert read_fleet(path).omega.tolist() == [5.0]


@pytest.mark.parametrize(
    ('file', 'content', 'shown'),
    [
        (FLEET, '', "its first line is ''"),
        (FLEET, '{header}\n0,1,1,1,1,1,1\n\n0,1,1,1\n', 'line 4: '),
        (FLEET, '{header}\n0,1,one,1,1,1,1\n', "line 2: could not convert string 'one'"),
        (FLEET, '{header}\n0,0,1,1,1,1,1\n', 'robot is 0; it must be from 1 to 2000'),
        (FLEET, '{header}\nnan,1,1,1,1,1,1\n', 't is nan; it must be from -1e+06 to 1e+06'),
        (COMMANDS, '{header},allowed_vx\n0,1,1,1,1\n', 'allowed_vx'),
        (DRAWINGS, '{header}\n0,1,ref,marker,0,0,0,red,1,1,1,1\n', 'red'),
    ],
)
def test_a_damaged_file_is_reported_with_the_requirement(tmp_path, file, content, shown):
    path = tmp_path / file.name
    path.write_text(content.format(header=file.header))

    with pytest.raises(SetcmasError) as error:
        file.read(path)

    assert str(path) in str(error.value)
    assert shown in str(error.value)
    assert file.header in str(error.value)
    assert '\n' not in str(error.value)


@pytest.mark.parametrize('content', [f'{FLEET.header}\n'.encode(), b'\xff\xfe\x00', None])
def test_other_files_that_are_no_tables(tmp_path, content):
    path = tmp_path / 'fleet.csv'
    if content:
        path.write_bytes(content)

    with pytest.raises(SetcmasError, match=r"fleet\.csv' (holds no rows|is damaged|cannot be)"):
        read_fleet(path)


@pytest.mark.parametrize('row', ['0,1,"[1"', '0,1,"{""x y"": 1}"', '0,1,NaN', f'0,1,{"[" * 9999}'])
def test_damaged_messages_are_reported(tmp_path, row):
    fleet = fleet_table([[0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0]])
    write_tables(RunTables(fleet), tmp_path)
    (tmp_path / 'messages.csv').write_text(f't,robot,value\n{row}\n')

    with pytest.raises(SetcmasError, match=r'messages\.csv'):
        read_tables(tmp_path / 'fleet.csv')
