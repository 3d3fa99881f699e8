from tables import compared, number, rows_of, worse

HEAD = "| part | tool | quads | SJ min | CPU s | |\n|---|---|---|---|---|---|\n"
TABLE = HEAD + ("| a | carreau | 3000 | 0.50 | 1.0 |  |\n| a | One | 3000 | 0.80 | 0.5 |  |\n"
                "| a | Two | 3000 | 0.90 | 2.0 | not an all-quad manifold |\n| b | carreau | 10 | 0.50 | 1.0 | |\n| b | One | failed | | | |\n")


def test_rows_know_their_file_group_and_tool():
    twice = HEAD + "| a | carreau | 1 | 0 | 0 | |\n| a | One | 1 | 0 | 0 | |\n| a | carreau | 2 | 0 | 0 | |\n| b | carreau | 3 | 0 | 0 | |\n"
    keys = [row.key for row in rows_of(twice)[1]]
    assert keys == [("a", 0, "carreau"), ("a", 0, "One"), ("a", 1, "carreau"), ("b", 0, "carreau")]


def test_a_row_tells_the_time_beside_the_fastest_peer_and_what_a_sound_peer_does_better():
    lines = compared("Some text.\n\n" + TABLE, {}).splitlines()
    assert lines[0] == "Some text."
    ours = lines[4]
    # The broken result of the second peer is no rival in shape.
    assert ours.endswith("| 2.00 | **SJ min**: One, **CPU s**: One |"), ours
    assert lines[5].endswith("|  |  |"), "peers' rows stay as they are"
    assert all(line.count("|") == lines[2].count("|") for line in lines[2:])


def test_only_the_peers_that_do_the_same_work_count():
    ours = compared(TABLE, {"carreau": ["Two"]}).splitlines()[2]
    assert ours.endswith("| 0.50 |  |"), ours


def test_figures_worse_by_more_than_a_tenth_are_told():
    now = TABLE.replace("| 0.50 | 1.0 |  |", "| 0.40 | 1.05 |  |")
    assert worse(now, TABLE) == ["a, carreau: SJ min is 0.40, was 0.50"]
    assert worse(TABLE, now) == []
    # A digit more of a small time is no news.
    assert worse(HEAD + "| a | carreau | 1 | 0.5 | 0.3 | |", HEAD + "| a | carreau | 1 | 0.5 | 0.2 | |") == []


def test_numbers_stand_before_their_unit():
    assert (number("99.24 %"), number("8.3°"), number("-0.5"), number("failed"), number("")) == (99.24, 8.3, -0.5, None, None)
