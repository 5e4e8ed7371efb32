"""Lines and tokens of a text are found where they stand."""

import numpy as np

from shapemorph.kernels.number_text import count_tokens, lines_with, read_decimals

TEXT = b"v 1 2\nvt 3\nv\t4 # 5\nv\nvn 6\n"
DATA = np.frombuffer(TEXT, dtype=np.uint8)
END = np.flatnonzero(ord("\n") == DATA)
START = np.concatenate([[0], END[:-1] + 1])


def test_a_keyword_needs_a_blank_behind_it():
    for keyword, rows in ((b"v", [0, 2]), (b"vt", [1]), (b"vn", [4]), (b"f", [])):
        found = lines_with(DATA, START, END, np.frombuffer(keyword, dtype=np.uint8))
        assert found.tolist() == rows


def test_tokens_end_at_a_comment_where_there_are_any():
    assert count_tokens(DATA, START, END, ord("#")).tolist() == [3, 2, 2, 1, 2]
    assert count_tokens(DATA, START, END, 0).tolist() == [3, 2, 4, 1, 2]


def test_long_and_strange_numbers_are_left_to_the_caller():
    text = b"1.5 -2e3\n0.12345678901234567\n1e-23\nnan\n1.2.3\n"
    data = np.frombuffer(text, dtype=np.uint8)
    end = np.flatnonzero(data == ord("\n"))
    start = np.concatenate([[0], end[:-1] + 1])
    values, left = read_decimals(data, start, end, count_tokens(data, start, end, 0), 0)
    assert values[:2].tolist() == [1.5, -2000.0]
    assert left.tolist() == [False, True, True, True, True]
