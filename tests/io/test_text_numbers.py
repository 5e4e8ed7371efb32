"""Numbers in text are read to the last bit, and what is none is named with its line."""

import numpy as np
import pytest

from shapemorph.io.text_numbers import NotANumberError, parse_corners, parse_floats


def test_every_way_to_write_a_number_gives_the_nearest_double():
    random = np.random.default_rng(0)
    numbers = (random.normal(size=600) * 10.0 ** random.integers(-30, 30, 600)).tolist()
    styles = ["{!r}", "{:.6g}", "{:.10f}", "{:e}", "{:.0f}", "+{:.3f}", "{:.17e}"]
    tokens = [styles[k % len(styles)].format(abs(number)) for k, number in enumerate(numbers)]
    tokens += [".5", "5.", "-0", "1E5", "1e400", "nan", "-inf", "-7.25e-3", "9007199254740993"]
    values, counts = parse_floats("\n".join(tokens).encode())
    expected = np.array([float(token) for token in tokens])
    np.testing.assert_array_equal(values, expected)
    np.testing.assert_array_equal(np.signbit(values), np.signbit(expected))
    assert counts.tolist() == [1] * len(tokens)


def test_lines_are_counted_with_and_without_a_last_break():
    for block in (b"1 2\n\n3", b"1\t2 \n\n 3\n"):
        values, counts = parse_floats(block)
        assert values.tolist() == [1, 2, 3]
        assert counts.tolist() == [2, 0, 1]
    assert parse_floats(b"")[0].size == 0


@pytest.mark.parametrize(
    "token", ["x", "1_0", "--5", "+-5", ".", "5e", "5e+", "0x10", "e5", "1.2.3", "-", "1#2"]
)
def test_what_is_no_number_is_named_with_its_line(token):
    with pytest.raises(NotANumberError) as caught:
        parse_floats(f"1 2\n3 {token} 4".encode())
    assert (caught.value.line, caught.value.token) == (1, token)


def corners(text):
    data = np.frombuffer(text, dtype=np.uint8)
    return parse_corners(data, np.array([0]), np.array([len(data)]), comment=ord("#"))


@pytest.mark.parametrize(
    ("text", "vertex", "texture"),
    [
        (b" 1/2/3 -4//5 6/ 7", [1, -4, 6, 7], [2, 0, 0, 0]),
        (b"1 2 3#4", [1, 2, 3], [0, 0, 0]),
        (b"+1/-2 3//\t", [1, 3], [-2, 0]),
    ],
)
def test_corners_of_every_form_are_read(text, vertex, texture):
    got_vertex, got_texture, counts = corners(text)
    assert got_vertex.tolist() == vertex
    assert got_texture.tolist() == texture
    assert counts.tolist() == [len(vertex)]


@pytest.mark.parametrize(
    ("text", "token"),
    [
        (b"1 /1", "a misplaced slash"),
        (b"1/2/3/4", "a misplaced slash"),
        (b"1///", "a misplaced slash"),
        (b"1 2/x", "x"),
        (b"1 2.5/1", "2.5"),
        (b"1 1/-", "-"),
        (b"12345678901234567890123", "12345678901234567890123"),
    ],
)
def test_corners_of_no_form_are_named(text, token):
    with pytest.raises(NotANumberError) as caught:
        corners(text)
    assert caught.value.token == token
