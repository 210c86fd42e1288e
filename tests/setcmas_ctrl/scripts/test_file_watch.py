import os

from setcmas_ctrl.scripts.file_watch import SETTLED_S, FileWatch


def test_a_save_is_noticed_once_it_has_settled(tmp_path):
    path = tmp_path / 'law.py'
    path.write_text('a')
    watch = FileWatch([path])
    assert not watch.poll(0.0)

    path.write_text('half of')
    assert not watch.poll(1.0)
    path.write_text('half of the file')
    assert not watch.poll(1.0 + SETTLED_S)  # it has changed again
    assert watch.poll(1.0 + 2 * SETTLED_S)
    assert not watch.poll(1.0 + 3 * SETTLED_S)


def test_a_file_of_the_same_size_and_time_that_takes_the_name_is_noticed(tmp_path):
    path, other = tmp_path / 'law.py', tmp_path / 'law.tmp'
    path.write_text('a')
    other.write_text('b')
    os.utime(other, ns=(path.stat().st_atime_ns, path.stat().st_mtime_ns))
    watch = FileWatch([path])

    other.replace(path)

    assert not watch.poll(0.0)
    assert watch.poll(SETTLED_S)


def test_a_file_that_is_away_or_empty_for_a_moment_is_waited_for(tmp_path):
    path = tmp_path / 'law.py'
    path.write_text('a')
    watch = FileWatch([path])

    path.unlink()
    assert not watch.poll(0.0)
    assert not watch.poll(SETTLED_S)
    path.touch()
    assert not watch.poll(2 * SETTLED_S)
    assert not watch.poll(3 * SETTLED_S)
    path.write_text('bc')
    assert not watch.poll(4 * SETTLED_S)
    assert watch.poll(5 * SETTLED_S)


def test_files_that_are_added_count_from_now_on_and_the_others_as_before(tmp_path):
    first, second = tmp_path / 'law.py', tmp_path / 'helper.py'
    first.write_text('a')
    watch = FileWatch([first])
    first.write_text('ab')
    second.write_text('b')

    watch.watch([first, second])

    assert not watch.poll(0.0)
    assert watch.poll(SETTLED_S)
    assert not watch.poll(2 * SETTLED_S)


def test_a_file_that_is_new_counts_as_saved_where_it_was_missing(tmp_path):
    first, second = tmp_path / 'law.py', tmp_path / 'helper.py'
    first.write_text('a')
    watch = FileWatch([first])
    watch.watch([first], new_are_saved=True)
    assert not watch.poll(0.0)
    second.write_text('b')

    watch.watch([first, second], new_are_saved=True)

    assert not watch.poll(1.0)
    assert watch.poll(1.0 + SETTLED_S)
    assert not watch.poll(1.0 + 2 * SETTLED_S)
