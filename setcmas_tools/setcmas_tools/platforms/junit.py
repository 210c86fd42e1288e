"""The format `junit`: a test suite for each submission, a test for each criterion."""

from __future__ import annotations

import re
from collections.abc import Sequence
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

from setcmas_tools.grade.check import student_view
from setcmas_tools.grade.criteria import points_text
from setcmas_tools.grade.marks import CriterionMark, Marks, ScenarioMark
from setcmas_tools.platforms.grade_format import (
    Files,
    GradeFormat,
    criterion_text,
    failure_text,
    summary,
)

_NOT_IN_XML = re.compile('[^\t\n\r -\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]')


def _files(marks: Sequence[Marks]) -> Files:
    suites = Element('testsuites', name=_text(marks[0].title))
    for one in map(student_view, marks):
        _add_suite(suites, one)
    for key in ('tests', 'failures'):
        suites.set(key, str(sum(int(suite.get(key, '0')) for suite in suites)))
    ElementTree.indent(suites)
    return {'junit.xml': ElementTree.tostring(suites, 'utf-8', xml_declaration=True) + b'\n'}


def _add_suite(suites: Element, marks: Marks) -> None:
    name = _text(f'{marks.student.name} ({marks.file or marks.submission})')
    suite = SubElement(suites, 'testsuite', name=name, errors='0')
    for one in marks.scenarios:
        for mark in one.criteria:
            _add_case(suite, one, mark)
    suite.set('tests', str(len(suite)))
    suite.set('failures', str(len(suite.findall('testcase/failure'))))
    texts = [summary(marks)]
    texts += [failure_text(one.failure) for one in marks.scenarios if one.failure]
    SubElement(suite, 'system-err').text = _text('\n'.join(filter(None, texts)))


def _add_case(suite: Element, scenario: ScenarioMark, mark: CriterionMark) -> None:
    place = {'classname': _text(scenario.name), 'name': _text(mark.name), 'time': '0'}
    case = SubElement(suite, 'testcase', place)
    if not mark.is_full:
        texts = f'{points_text(mark.points)} of {points_text(mark.max_points)} points'
        SubElement(case, 'failure', message=texts).text = _text(criterion_text(mark))


def _text(text: str) -> str:
    return _NOT_IN_XML.sub('\N{REPLACEMENT CHARACTER}', text)


JUNIT = GradeFormat('JUnit XML, for continuous integration', _files)
