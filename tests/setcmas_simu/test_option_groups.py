import argparse
import math
from dataclasses import dataclass, replace
from pathlib import Path
from typing import ClassVar

import pytest

from setcmas_simu.errors import SetcmasError
from setcmas_simu.option_groups import ClashError, Form, Options, flag, option, take_values
from setcmas_simu.option_kinds import Kind, Number, OneOf, PathTo, Robots


@dataclass(frozen=True, kw_only=True)
class Base(Options):
    noise: float = option(Number(least=0, unit='m'), 'of poses', default=0.25)


@dataclass(frozen=True, kw_only=True)
class Robot(Base):
    TITLE: ClassVar[str] = 'robot'

    law: str = option(Kind(metavar='NAME'), 'what it does')
    v_max: float = option(Number(above=0, unit='m/s'), 'its speed', default=math.inf)
    shape: str | None = option(OneOf(('disc', 'box')), 'its shape', default=None, alone='disc')
    map: Path | None = option(PathTo(), 'where it is', default=None, short='-m')
    tag: tuple[str, ...] = option(Kind(), 'its tags', default=(), form=Form.REPEATED)
    kinds: tuple[str, ...] = option(
        OneOf(('a', 'b')), 'of plots', default=('a',), form=Form.SEVERAL
    )
    others: tuple[int, ...] | None = option(Robots(), 'beside it', default=None)
    quiet: bool = flag('says nothing')
    guard: bool = flag('is guarded', True)

    def check(self):
        if self.quiet and self.tag:
            raise ClashError('{} goes without {}', 'quiet', 'tag')


def parser_of(group, **known):
    parser = argparse.ArgumentParser(prog='robot', allow_abbrev=False)
    group.add_to(parser, **known)
    return parser


def parsed(*arguments):
    return Robot.of(parser_of(Robot).parse_args(['--law', 'go', *arguments]))


EVERY = replace(
    Robot(law='go'),
    noise=0.1 + 0.2,
    v_max=1.5,
    shape='box',
    map=Path('a b.yaml'),
    tag=('-x', 'y=z'),
    kinds=('b', 'a'),
    others=(1, 2, 3),
    guard=False,
)


def test_defaults():
    assert parsed() == Robot(law='go')


@pytest.mark.parametrize('options', [Robot(law='go'), Robot(law='-go', quiet=True), EVERY])
def test_a_process_gets_the_same_values(options):
    parser = parser_of(Robot)
    take_values(parser)
    assert Robot.of(parser.parse_args(options.arguments())) == options


def test_only_what_differs_is_passed_on():
    assert parsed('--noise', '1').arguments() == ['--values', '{law: go, noise: 1.0}']
    assert parsed('--noise', '1').changed() == {'law': 'go', 'noise': 1.0}


def test_a_mistake_in_passed_values_names_the_value(capsys):
    parser = parser_of(Robot)
    take_values(parser)
    with pytest.raises(SystemExit):
        parser.parse_args(['--values', '{law: go, nois: 1}'])
    assert "there is no key 'nois'" in capsys.readouterr().err


def test_forms():
    assert parsed('--shape').shape == 'disc'
    assert parsed('--v-max', 'inf').v_max == math.inf
    assert parsed('-m', 'x').map == Path('x')
    assert not parsed('--no-guard').guard


def test_options_that_a_command_lacks_keep_their_defaults():
    parser = parser_of(Robot, without=('v_max',), noise=3.0)

    assert Robot.of(parser.parse_args(['--law=go'])) == Robot(law='go', noise=3.0)
    with pytest.raises(SystemExit):
        parser.parse_args(['--law=go', '--v-max=1'])


@pytest.mark.parametrize(
    ('arguments', 'message'),
    [
        (('--noise', 'nan'), '--noise is nan; it must be at least 0 m'),
        (('--v-max=x',), "--v-max is 'x'; it must be a number above 0 m/s"),
        (('--shape', 'ball'), "--shape is 'ball'; it must be disc or box"),
        (('--others', '3-1'), "--others is '3-1'; it must be numbers"),
        ((), 'required: --law'),
    ],
)
def test_mistakes_are_reported_with_the_names_of_options(arguments, message, capsys):
    with pytest.raises(SystemExit) as status:
        parser_of(Robot).parse_args(arguments)

    assert status.value.code == 2
    assert message in capsys.readouterr().err


def test_mistakes_are_reported_with_the_names_of_arguments():
    with pytest.raises(SetcmasError, match=r'^v_max is -1; it must be above 0 m/s$'):
        Robot(law='go', v_max=-1)
    with pytest.raises(SetcmasError, match=r'^law is 3; it must be a text$'):
        Robot(law=3)


def test_conflicting_options_are_reported_by_option_or_argument():
    with pytest.raises(SetcmasError, match=r'^quiet goes without tag$'):
        Robot(law='go', quiet=True, tag=('x',))
    with pytest.raises(SetcmasError, match=r'^--quiet goes without --tag$'):
        parsed('--quiet', '--tag', 'x')


def test_the_help_shows_units_and_defaults_and_the_classes_own_options_first():
    text = parser_of(Robot).format_help()

    assert '\nrobot:\n' in text
    assert '--noise M ' in text
    assert 'of poses (default: 0.25 m)' in text
    assert '{disc,box}' in text
    assert text.index('--guard') < text.index('--noise')


def test_groups_of_one_title_share_it():
    @dataclass(frozen=True, kw_only=True)
    class More(Options):
        TITLE: ClassVar[str] = 'robot'
        more: bool = flag('of it')

    parser = parser_of(Robot)
    More.add_to(parser)

    assert parser.format_help().count('\nrobot:\n') == 1


def test_what_is_recorded_is_plain():
    record = EVERY.record()

    assert record['map'] == 'a b.yaml'
    assert record['tag'] == ['-x', 'y=z']
    assert record['others'] == [1, 2, 3]
    assert record['v_max'] == 1.5
    assert Robot(law='go').record()['v_max'] is None
