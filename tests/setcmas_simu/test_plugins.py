"""Plugins of packages that are really installed: folders with metadata on the path."""

import os
import sys
import zipfile

import pytest

from setcmas_simu import plugins
from setcmas_simu.errors import SetcmasError
from setcmas_simu.plugins import InvalidPluginError, PluginGroup, ScriptGroup, instance_of

GROUP = 'setcmas.test_things'
THINGS = PluginGroup(GROUP, 'thing', instance_of(int))
LAWS = ScriptGroup('setcmas.algorithms', 'control law')


def forget():
    """Look all plugins up again, as a new process does."""
    plugins._entries.cache_clear()
    plugins._plugins.cache_clear()


@pytest.fixture
def install(tmp_path, monkeypatch):
    """Return a function that installs a package with a module `law`, as pip lays it out."""
    monkeypatch.syspath_prepend(tmp_path)

    def add(package, code, group=GROUP, **names):
        (tmp_path / package).mkdir()
        (tmp_path / package / '__init__.py').write_text(code)
        (tmp_path / package / 'law.py').write_text('raise RuntimeError')
        metadata = tmp_path / f'{package}-1.2.dist-info'
        metadata.mkdir()
        (metadata / 'METADATA').write_text(f'Metadata-Version: 2.1\nName: {package}\nVersion: 1.2')
        lines = [f'{name} = {package}{target}\n' for name, target in names.items()]
        (metadata / 'entry_points.txt').write_text(f'[{group}]\n' + ''.join(lines))

    forget()
    yield add
    forget()


def test_a_thing_of_a_package_is_found_by_name(install):
    install('pack_a', 'ONE = 1\nTWO = 2\n', one=':ONE', two=':TWO')

    assert list(THINGS.plugins()) == ['one', 'two']
    assert (THINGS.plugin('two').package, THINGS.plugin('two').version) == ('pack_a', '1.2')
    assert not THINGS.plugin('two').built_in
    assert THINGS.get('two') == 2


def entry_points(place, text, metadata='Name: pack-m\nVersion: 2.0\n'):
    """Write a folder of metadata; entry points in bytes are in no known encoding."""
    place.mkdir(parents=True)
    (place / 'entry_points.txt').write_bytes(text if isinstance(text, bytes) else text.encode())
    if metadata:
        (place / 'PKG-INFO').write_text(metadata)


@pytest.mark.parametrize('layout', ['folder', 'archive'])
@pytest.mark.parametrize('metadata', ['pack_m-2.0.egg/EGG-INFO', 'on_path/pack_m-2.0.dist-info'])
def test_plugins_of_eggs_and_archives_on_the_path_are_found(
    install, tmp_path, monkeypatch, layout, metadata
):
    folder = tmp_path / metadata
    entry_points(folder, f'[{GROUP}]\none = pack_m:ONE\n')
    if layout == 'archive':
        (packed := tmp_path / 'packed').mkdir()
        with zipfile.ZipFile(packed / folder.parent.name, 'w') as archive:
            for file in folder.iterdir():
                archive.write(file, f'{folder.name}/{file.name}')
        monkeypatch.syspath_prepend(packed / folder.parent.name)
    else:
        monkeypatch.syspath_prepend(folder.parent)

    assert THINGS.plugin('one').title == "'one' of package pack-m 2.0"


def test_a_package_without_its_own_metadata_is_named_as_its_folder(install, tmp_path):
    entry_points(tmp_path / 'pack_m-2.0.dist-info', f'[{GROUP}]\none = pack_m:ONE\n', '')

    assert THINGS.plugin('one').title == "'one' of package pack_m 2.0"


def test_a_folder_that_is_only_called_info_hides_no_package(install, tmp_path, monkeypatch):
    install('pack_a', 'ONE = 1\n', one=':ONE')
    (tmp_path / 'first' / 'pack_a-info').mkdir(parents=True)
    monkeypatch.syspath_prepend(tmp_path / 'first')

    assert THINGS.get('one') == 1


def test_entry_points_in_an_unknown_encoding_stop_no_other_package(install, tmp_path):
    install('pack_a', 'ONE = 1\n', one=':ONE')
    entry_points(tmp_path / 'pack_m-2.0.dist-info', '# é\n[other]\n'.encode('latin-1'))

    assert THINGS.get('one') == 1


@pytest.mark.skipif(os.geteuid() == 0, reason='root may read all files')
def test_metadata_that_cannot_be_read_stop_no_other_package(install, tmp_path):
    install('pack_a', 'ONE = 1\n', one=':ONE')
    for name in ('pack_m-2.0.dist-info', 'pack_n-2.0.dist-info'):
        entry_points(tmp_path / name, f'[{GROUP}]\ntwo = pack_m:TWO\n')
    (tmp_path / 'pack_m-2.0.dist-info').chmod(0)
    (tmp_path / 'pack_n-2.0.dist-info' / 'entry_points.txt').chmod(0)

    assert list(THINGS.plugins()) == ['one']


def test_extras_of_a_package_are_no_part_of_a_module(install, tmp_path):
    install('pack_e', '', group=LAWS.name, own='.law [fast]')

    assert LAWS.file('own') == tmp_path / 'pack_e' / 'law.py'


def test_packages_with_plugins_are_named_with_their_versions(install):
    install('pack_a', 'ONE = 1\n', one=':ONE')
    install('pack_c', '', group='other.things', one=':ONE')

    versions = plugins.plugin_versions()

    assert versions['pack_a'] == '1.2'
    assert not {'pack_c', 'setcmas'} & versions.keys()


def test_nothing_is_imported_before_it_is_asked_for(install):
    install('pack_b', 'raise RuntimeError("too early")\n', one=':ONE')

    assert list(THINGS.plugins()) == ['one']
    assert 'pack_b' not in sys.modules


@pytest.mark.parametrize(
    ('code', 'reason'),
    [
        (
            'x = 1\nraise RuntimeError("no\\nhardware")',
            r'RuntimeError: no hardware \(\w+\.py, line 2',
        ),
        ('import no_such_module', 'ModuleNotFoundError.*no_such_module'),
        ('def f(:', 'SyntaxError.*line 1'),
        ('import sys\nsys.exit(3)', 'SystemExit: 3'),
        ('OTHER = 1', 'AttributeError.*ONE'),
        ('ONE = "1"', 'it is a str; it must be a int'),
    ],
    ids=['raises', 'imports', 'syntax', 'exits', 'lacks', 'does_not_fit'],
)
def test_a_plugin_that_cannot_be_used_is_reported_in_one_line_and_the_others_go_on(
    install, request, code, reason
):
    package = f'pack_{request.node.callspec.id}'
    install(package, code, one=':ONE')
    install(f'good_{package}', 'TWO = 2', two=':TWO')
    warnings = []

    with pytest.raises(
        SetcmasError, match=f"thing 'one' of package {package} 1.2 .*{reason}"
    ) as e:
        THINGS.get('one')

    assert '\n' not in str(e.value)
    assert THINGS.usable(warnings.append) == {'two': 2}
    assert warnings == [str(e.value)]


def test_an_unknown_name_is_reported_with_the_known_ones(install):
    install('pack_c', 'ONE = 1', first=':ONE', second=':ONE')

    with pytest.raises(
        SetcmasError,
        match=r"unknown thing 'frst'; did you mean first\? It must be one of first, second$",
    ):
        THINGS.get('frst')


def test_a_group_without_plugins_says_that_the_installation_is_incomplete(install):
    with pytest.raises(SetcmasError, match='no thing is installed; install setcmas again'):
        THINGS.get('one')


def test_a_shipped_name_hides_a_plugin_with_a_warning(install, capsys):
    install('pack_d', '', group='setcmas.algorithms', consensus='', own='')

    assert LAWS.plugin('consensus').package == 'setcmas'
    assert LAWS.plugin('consensus').hidden == ('pack_d',)
    assert LAWS.file('consensus').parent.name == 'algorithms'
    assert capsys.readouterr().err.count("pack_d also has a control law 'consensus'") == 1
    assert list(LAWS.plugins())[-1] == 'own'


def test_a_script_is_found_as_a_file_and_not_run(install, tmp_path):
    install('pack_e', '', group=LAWS.name, own='.law')

    assert LAWS.file('own') == tmp_path / 'pack_e' / 'law.py'


@pytest.mark.parametrize(
    ('code', 'target', 'reason'),
    [
        ('', '.lost', r'its module \w+.lost was not found'),
        ('1 / 0', '.law', 'ZeroDivisionError'),
        ('', '', 'must be in a package'),
    ],
)
def test_a_script_that_cannot_be_found_is_reported_with_its_package(install, code, target, reason):
    package = f'pack_of{target[1:]}_{len(code)}'
    install(package, code, group=LAWS.name, own=target)

    with pytest.raises(SetcmasError, match=f"'own' of package {package} .*{reason}"):
        LAWS.file('own')


def test_a_check_of_ones_own_says_why_a_thing_does_not_fit(install):
    def check(thing):
        raise InvalidPluginError('it must have wheels')

    install('pack_f', 'ONE = 1', one=':ONE')

    with pytest.raises(SetcmasError, match=r'cannot be used: it must have wheels$'):
        PluginGroup(GROUP, 'thing', check).get('one')


def test_unknown_groups_are_found(install):
    install('pack_g', '', group='setcmas.metric', one=':ONE')

    assert plugins.unknown_groups() == {'setcmas.metric': ['pack_g']}
    built_in = {group for group in plugins._groups() if group not in plugins.unknown_groups()}
    assert built_in == {*plugins.GROUPS}
