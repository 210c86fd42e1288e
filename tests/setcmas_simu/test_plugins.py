"""Plugins of packages that are really installed: folders with metadata on the path."""

import sys

import pytest

from setcmas_simu import plugins
from setcmas_simu.errors import SetcmasError
from setcmas_simu.plugins import InvalidPluginError, PluginGroup, ScriptGroup

GROUP = 'setcmas.test_things'


def a_whole_number(thing):
    if not isinstance(thing, int):
        raise InvalidPluginError(f'it is a {type(thing).__name__}; it must be a int')
    return thing


THINGS = PluginGroup(GROUP, 'thing', a_whole_number)
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


def test_a_shipped_name_counts_before_that_of_a_package(install):
    install('pack_d', '', group='setcmas.algorithms', consensus='', own='')

    assert LAWS.plugin('consensus').package == 'setcmas'
    assert LAWS.file('consensus').parent.name == 'algorithms'
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
