"""Rubric: scenarios for a submission, and criteria with points."""

from __future__ import annotations

import ast
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from setcmas_ctrl.laws.script_imports import with_helpers
from setcmas_ctrl.laws.script_loader import ALGORITHMS, EXERCISES
from setcmas_ctrl.laws.script_search import FUNCTIONS, exercise_of, solution_of
from setcmas_simu.errors import SetcmasError, did_you_mean
from setcmas_simu.option_kinds import Number, OneOf, Whole
from setcmas_simu.script_calls import Function
from setcmas_simu.yaml_entries import Entry, read_entries
from setcmas_tools.grade.criteria import (
    COMPARED,
    OF_ANSWERS,
    UNITS,
    Criterion,
    figures_of,
    read_criteria,
)
from setcmas_tools.offline.offline_simulation import silent, simulate
from setcmas_tools.run.run import Run
from setcmas_tools.run.run_tables import FLEET, read_tables
from setcmas_tools.run.scenario import Scenario, options
from setcmas_tools.run.scenario_files import OF_FILES, placed_in

SUBMITTED = {
    Function.CONTROL: ('algo', 'exercise'),
    Function.CONDITION: ('ctc', 'event_triggered'),
    Function.SI_TO_UNI: ('si_to_uni',),
}
"""Values of scenarios that a submission gives, by its function; the first is the submission."""

_OWN = ('name', 'criteria', 'hidden', 'compared_robots')


@dataclass(frozen=True)
class MarkedScenario:
    """A scenario to run with a submission, and the criteria for its run.

    Attributes:
        name: Its name, unique in the rubric.
        criteria: Criteria for its run.
        base: The scenario without the submission.
        hidden: Whether students only see its points.
        robots: Those whose answers are compared with the solution; empty for all.
    """

    name: str
    criteria: tuple[Criterion, ...]
    base: Scenario
    hidden: bool = False
    robots: tuple[int, ...] = ()

    def with_submission(self, submission: Any, function: Function = Function.CONTROL) -> Scenario:
        """Return the scenario with a submission as its law, condition or si_to_uni.

        Args:
            submission: A script, a function, or a function for each robot, {1: ..., 2: ...}.
            function: Which function the submission is, one of FUNCTIONS.
        """
        return self.base.replace(**{SUBMITTED[function][0]: submission})

    def shown(self) -> MarkedScenario:
        """Return the scenario without hidden criteria."""
        criteria = [one for one in self.criteria if not one.hidden]
        names = {one.name for one in criteria}
        shown = (one if one.needs in names else replace(one, needs='') for one in criteria)
        return replace(self, criteria=tuple(shown))

    @property
    def files(self) -> tuple[Path, ...]:
        """The files that it names."""
        named = [Path(text) for name in OF_FILES for text in self.base.named(name)]
        return tuple(path for path in named if path.is_absolute())


@dataclass(frozen=True)
class TypicalMistake:
    """A typical mistake: an altered solution, and the hint for those who make it.

    Attributes:
        hint: Text for the student.
        change: Parts of the solution's source, and what replaces them.
        script: A whole script instead; '' for changes.
        term: What the change leaves out, for hints about its factor; '' for none.
    """

    hint: str
    change: Mapping[str, str] = field(default_factory=dict)
    script: str = ''
    term: str = ''

    def source(self, solution: Path | None) -> str:
        """Return the source of the altered solution."""
        text = self.script or (solution.read_text(encoding='utf-8') if solution else '')
        for old, new in self.change.items():
            text = text.replace(old, new)
        return text


_KEYS = (
    'title', 'exercise', 'function', 'solution', 'references', 'mistakes', 'hidden_points',
    'scenarios',
)  # fmt: skip


@dataclass(frozen=True)
class Rubric:
    """Scenarios and criteria for marking submissions.

    Attributes:
        function: Function that submissions define, one of FUNCTIONS.
        exercise: Name of its exercise; '' without one.
        solution: Script whose paths are the reference; None is the default condition, the
            built-in si_to_uni, or no solution.
        mistakes: Typical mistakes with their hints.
        references: Folders with the solution's runs by scenario, for students without the
            solution; empty if it is there.
        hidden_points: Points of the parts that have been left out of it.
    """

    file: Path
    title: str
    scenarios: tuple[MarkedScenario, ...]
    function: Function = Function.CONTROL
    exercise: str = ''
    solution: Path | None = None
    mistakes: tuple[TypicalMistake, ...] = ()
    references: Mapping[str, Path] = field(default_factory=dict)
    hidden_points: float = 0.0
    _runs: dict[str, Run] = field(default_factory=dict, compare=False, repr=False)

    @property
    def max_score(self) -> float:
        """Largest possible points."""
        return sum(one.points for scenario in self.scenarios for one in scenario.criteria)

    @property
    def compares_answers(self) -> bool:
        """Whether a criterion asks for the solution's answers."""
        criteria = (one for scenario in self.scenarios for one in scenario.criteria)
        return any(one.metric in OF_ANSWERS for one in criteria)

    @property
    def files(self) -> tuple[Path, ...]:
        """All its files: the rubric itself, the solution, and the files of scenarios.

        After each script come its helper modules.
        """
        named = [file for scenario in self.scenarios for file in scenario.files]
        named += [file for one in self.references.values() for file in sorted(one.glob('*'))]
        solution = [self.solution] if self.solution else []
        found = (one for file in [self.file, *solution, *named] for one in with_helpers(file))
        return tuple(dict.fromkeys(found))

    def _check_metrics(self, scenario: MarkedScenario, run: Run) -> None:
        """Check that the solution's run has the metric of each criterion."""
        others = [one.metric for one in scenario.criteria if one.metric not in UNITS]
        known = figures_of(run) if others else {}
        for metric in others:
            if metric not in known:
                raise SetcmasError(
                    f"{metric}, in scenario '{scenario.name}' of {self.file}, is not a metric of "
                    f'its run; it must be one of setcmas list, or of plugins: '
                    f'{", ".join(sorted(known.keys() - UNITS.keys())) or "none"}'
                )

    def shown(self) -> Rubric:
        """Return the rubric without hidden parts."""
        scenarios = [one.shown() for one in self.scenarios if not one.hidden]
        shown = replace(self, scenarios=tuple(one for one in scenarios if one.criteria))
        hidden = self.hidden_points + self.max_score - shown.max_score
        return replace(shown, hidden_points=hidden)

    def solution_run(self, scenario: MarkedScenario) -> Run | None:
        """Return the run of the model solution, made once; None if there is no solution.

        Raises:
            SetcmasError: The solution does not load, or fails, or its run is missing or lacks the
                metric of a criterion.
        """
        if self.function is Function.CONTROL and not self.solution and not self.references:
            return None
        if scenario.name not in self._runs:
            if self.references:
                run = Run(**vars(read_tables(self.references[scenario.name] / FLEET.name)))
            else:
                run = self._simulated_solution(scenario)
            self._check_metrics(scenario, run)
            self._runs[scenario.name] = run
        return self._runs[scenario.name]

    def _simulated_solution(self, scenario: MarkedScenario) -> Run:
        messages: list[str] = []
        chosen = scenario.with_submission(self.solution, self.function)
        with silent():  # students would take its lines for those of their own script
            run = simulate(chosen, warn=messages.append)
        if run.failed_robots:
            raise SetcmasError(
                f"the solution fails in scenario '{scenario.name}' of {self.file}: {messages[0]}"
            )
        return run


def chosen_rubric(script: Path | None, rubric: str | Path | None) -> Rubric:
    """Return the rubric with this name or file, or of the exercise that a script names.

    Raises:
        SetcmasError: There is none.
    """
    if rubric is None:
        rubric = exercise_of(script) if script else ''
        if not rubric:
            raise SetcmasError(
                f'{script.name if script else "a function"} names no exercise; give a rubric, or '
                f'one of {", ".join(EXERCISES.plugins())} (in a script, name it in a line such '
                "as exercise = 'consensus')"
            )
    if str(rubric) in EXERCISES:
        return rubric_of_exercise(str(rubric))
    if not Path(rubric).exists():
        names = EXERCISES.plugins()
        hint = did_you_mean(rubric, names) or f'; give a file, or one of {", ".join(names)}'
        raise SetcmasError(f"there is no rubric '{rubric}'{hint}")
    return read_rubric(Path(rubric))


def rubric_of_exercise(name: str) -> Rubric:
    """Return the rubric of an exercise: NAME.yaml in the folder of its script.

    Raises:
        SetcmasError: The exercise is unknown, or its rubric is missing or invalid.
    """
    file = EXERCISES.file(name).with_suffix('.yaml')
    if not file.is_file():
        raise SetcmasError(f"exercise '{name}' has no rubric; give one with --rubric R.yaml")
    return read_rubric(file)


def read_rubric(path: Path) -> Rubric:
    """Read a rubric from a file.

    Raises:
        SetcmasError: The file is invalid; the message has file and line.
    """
    content = read_entries(path)
    if not content.value:
        raise SetcmasError(f"rubric '{path}' is empty; it must have a list of scenarios")
    fields = content.fields(_KEYS)
    exercise = (
        OneOf(tuple(EXERCISES.plugins())).of(fields['exercise']) if 'exercise' in fields else ''
    )
    function = Function.CONTROL
    if 'function' in fields:
        names = tuple(one.value for one in FUNCTIONS)
        function = Function(OneOf(names).of(fields['function']))
    elif exercise:
        tree = ast.parse(EXERCISES.file(exercise).read_bytes())
        defined = {node.name for node in tree.body if isinstance(node, ast.FunctionDef)}
        function = next(one for one in FUNCTIONS if one.value in defined)
    if 'scenarios' not in fields:
        raise content.mistake('a rubric with a list of scenarios')
    solution = None
    references = _references(fields['references']) if 'references' in fields else {}
    if references and 'solution' in fields:
        raise fields['references'].error('references replace the solution; remove one of them')
    if 'solution' in fields:
        solution = _read_solution(fields['solution'])
    elif exercise and not references:
        solution = solution_of(exercise, function)
    scenarios = _scenarios(fields['scenarios'], function, bool(solution or references))
    if references and (others := {one.name for one in scenarios} - references.keys()):
        raise fields['references'].error(f"references lack scenario '{min(others)}'")
    mistakes = fields['mistakes'].items() if 'mistakes' in fields else ()
    rubric = Rubric(
        file=path.resolve(),
        title=fields['title'].text() if 'title' in fields else path.stem,
        scenarios=scenarios,
        function=function,
        exercise=exercise,
        solution=solution,
        mistakes=tuple(_mistake(item, solution) for item in mistakes),
        references=references,
        hidden_points=_POINTS.of(fields['hidden_points']) if 'hidden_points' in fields else 0.0,
    )
    if references and rubric.compares_answers:
        raise fields['references'].error(
            'references cannot replace the solution, because answers are compared with it'
        )
    return rubric


def _references(entry: Entry) -> dict[str, Path]:
    """Return the folders of the solution's runs by the names of scenarios."""
    if not isinstance(entry.value, dict) or not entry.value:
        raise entry.mistake('a mapping from scenarios to folders, made by setcmas grade --handout')
    files: dict[str, Path] = {}
    for name, one in entry.value.items():
        with one.located():
            file = placed_in(entry.file.parent, 'references', f'{one.text()}/{FLEET.name}')
            files[name] = Path(file).parent
    return files


def _scenarios(entry: Entry, function: Function, is_compared: bool) -> tuple[MarkedScenario, ...]:
    scenarios: list[MarkedScenario] = []
    for item in entry.items():
        scenario = _scenario(item, function)
        if scenario.name in (one.name for one in scenarios):
            raise item.error(f"two scenarios are named '{scenario.name}'; rename one")
        needing = [one.metric for one in scenario.criteria if one.metric in COMPARED]
        filtered = [one.metric for one in scenario.criteria if one.metric.startswith('filter_')]
        if filtered and not scenario.base.safety.is_on:
            raise item.error(f'{filtered[0]} is measured with a filter only; add filter: barrier')
        if needing and function is Function.CONTROL and not is_compared:
            raise item.error(f'{needing[0]} needs a solution for comparison; add solution: FILE')
        scenarios.append(scenario)
    if not scenarios:
        raise entry.mistake('a list with at least one scenario')
    return tuple(scenarios)


def _scenario(entry: Entry, function: Function) -> MarkedScenario:
    """Return the scenario of an entry of a rubric."""
    values = (name for name in options() if name not in SUBMITTED[function])
    fields = entry.fields((*_OWN, *values))
    for name in ('name', 'criteria'):
        if name not in fields:
            raise entry.mistake(f'a scenario with a {name}, such as {_EXAMPLES[name]}')
    name = fields['name'].text()
    given = {key: one for key, one in fields.items() if key not in _OWN}
    base = Scenario.of('')
    if function is Function.CONDITION:
        base = Scenario.of(str(ALGORITHMS.file('consensus')), event_triggered=True)
    elif function is Function.SI_TO_UNI:
        base = Scenario.of(str(ALGORITHMS.file('nav_wp')))
    base = Scenario.read(replace(entry, value=given), base)
    hidden = 'hidden' in fields and fields['hidden'].flag()
    criteria = read_criteria(fields['criteria'])
    of_fleet = Whole(1, most=base.nb_robots)
    listed = fields['compared_robots'].items() if 'compared_robots' in fields else ()
    robots = tuple(of_fleet.of(one) for one in listed)
    with entry.located():
        base.start_poses()
    return MarkedScenario(name, criteria, base, hidden, robots)


_POINTS = Number(least=0.0)
_EXAMPLES = {'name': 'name: eight robots', 'criteria': 'criteria: [{metric: ..., at_most: ...}]'}


def _read_solution(entry: Entry) -> Path:
    """Return the script of a solution: a file in the rubric's folder, or a built-in law."""
    try:
        return Path(placed_in(entry.file.parent, 'algo', entry.text()))
    except SetcmasError as error:
        raise entry.error(
            f"the solution of this rubric, '{entry.text()}', is missing: {error}. Students need "
            'a copy without it, which `setcmas grade --handout` writes'
        ) from None


def _mistake(entry: Entry, solution: Path | None) -> TypicalMistake:
    fields = entry.fields(('change', 'script', 'hint', 'term'))
    if 'hint' not in fields or ('change' in fields) == ('script' in fields):
        raise entry.mistake('a mistake with a hint, and with change: {OLD: NEW} or a script')
    hint = ' '.join(fields['hint'].text().split())
    if 'script' in fields:
        mistake = TypicalMistake(hint, script=fields['script'].text())
    else:
        term = fields['term'].text() if 'term' in fields else ''
        mistake = TypicalMistake(hint, _changes(fields['change'], solution), term=term)
    try:
        compile(mistake.source(solution), '', 'exec')
    except (SyntaxError, ValueError) as error:
        raise entry.error(f'this mistake is not valid Python: {error}') from error
    return mistake


def _changes(changes: Entry, solution: Path | None) -> dict[str, str]:
    if solution is None:
        raise changes.error('there is no solution to change; add one, or write script: instead')
    if not isinstance(changes.value, dict) or not changes.value:
        raise changes.mistake('parts of the solution with their replacements: {OLD: NEW}')
    source = solution.read_text(encoding='utf-8')
    for old in changes.value:
        if str(old) not in source:
            raise changes.error(f"the solution, {solution.name}, has no '{old}' to change")
    return {str(old): one.text() for old, one in changes.value.items()}
