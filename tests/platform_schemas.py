"""JSON schemas of what learning platforms document that they read."""

_TEXT, _POINTS = {'type': 'string'}, {'type': 'number', 'minimum': 0}


def _closed(properties, *required):
    """Return the schema of an object with these properties and no others."""
    return {
        'type': 'object',
        'properties': properties,
        'required': list(required),
        'additionalProperties': False,
    }


_VISIBILITY = {'enum': ['hidden', 'after_due_date', 'after_published', 'visible']}

SCHEMAS = {
    # gradescope-autograders.readthedocs.io, specs
    'gradescope': _closed(
        {
            'score': _POINTS,
            'execution_time': _POINTS,
            'output': _TEXT,
            'visibility': _VISIBILITY,
            'stdout_visibility': _VISIBILITY,
            'extra_data': {'type': 'object'},
            'leaderboard': {'type': 'array'},
            'tests': {
                'type': 'array',
                'items': _closed(
                    {
                        'score': _POINTS,
                        'max_score': _POINTS,
                        'name': _TEXT,
                        'number': _TEXT,
                        'output': _TEXT,
                        'tags': {'type': 'array', 'items': _TEXT},
                        'visibility': _VISIBILITY,
                        'extra_data': {'type': 'object'},
                    },
                    'score',
                ),
            },
        },
        'score',
    ),
    # CodeRunner, documentation of combinator template grading
    'coderunner': _closed(
        {
            'fraction': {'type': 'number', 'minimum': 0, 'maximum': 1},
            'prologuehtml': _TEXT,
            'testresults': {
                'type': 'array',
                'minItems': 1,
                'items': {'type': 'array', 'minItems': 7, 'maxItems': 7},
            },
            'columnformats': {'type': 'array', 'items': {'enum': ['%s', '%h']}},
            'epiloguehtml': _TEXT,
            'instructorhtml': _TEXT,
            'showdifferences': {'type': 'boolean'},
        },
        'fraction',
    ),
}
