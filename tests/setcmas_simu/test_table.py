from setcmas_simu.table import Table

TABLE = Table([['tb3_1', '5.00'], ['tb3_12', '-']], ['robot', 'path\n(m)'], 'lr')


def test_columns_are_aligned_below_heads_of_several_lines():
    assert str(TABLE).splitlines() == [
        'robot      path',
        '            (m)',
        '-------  ------',
        'tb3_1      5.00',
        'tb3_12        -',
    ]


def test_a_table_without_heads_has_no_rule_and_one_without_rows_no_lines():
    assert str(Table([['a', 'b'], ['long', 'c']])).splitlines() == ['a     b', 'long  c']
    assert str(Table([], ['head'])) == Table([]).html() == ''


def test_texts_are_escaped_in_html():
    html = Table([['<b>', '1']], ['name', 'points'], 'lr').html()

    assert '<td>&lt;b&gt;</td><td style="text-align: right;">1</td>' in html
    assert html.startswith('<table>\n<thead>')
