"""How the readings of a run make rounds: with labels, without, in one direction or both, closed or not."""

import numpy as np
import pytest

from arcref.calibration.polygon_run import read_polygon_run


@pytest.fixture
def read(tmp_path):
    """Reads a run of 6 faces with these positions, x counting the rows: `read(positions, round=, direction=)`."""

    def reader(positions, faces=6, name="position_deg", **labels):
        path = tmp_path / "run.csv"
        columns = [name, *labels, "autocollimator_x_arcsec"]
        rows = zip(positions, *labels.values(), range(len(positions)), strict=True)
        lines = [f"# faces: {faces}", ",".join(columns), *(",".join(map(str, row)) for row in rows)]
        path.write_text("\n".join(lines) + "\n", encoding="utf-8")
        return read_polygon_run(path)

    return reader


FORWARD = [0, 60, 120, 180, 240, 300]
BACKWARD = [360, 300, 240, 180, 120, 60]


def shape(run):
    """Direction, first and closing reading of each series."""
    series = run.series
    return list(zip(series.direction, series.first_reading.tolist(), series.closing_reading.tolist(), strict=True))


def test_one_round_open_and_closed(read):
    assert shape(read(FORWARD)) == [(1, 0, -1)]
    assert shape(read([*FORWARD, 360])) == [(1, 0, 6)]
    assert shape(read([*FORWARD, 0])) == [(1, 0, 6)]
    assert shape(read([*BACKWARD, 0])) == [(-1, 0, 6)]


def test_turning_on_without_labels_closes_each_round_with_the_next(read):
    positions = [60 * step for step in range(19)]  # three turns and the first face again
    assert shape(read(positions)) == [(1, 0, 6), (1, 6, 12), (1, 12, 18)]
    assert shape(read([position % 360 for position in positions])) == [(1, 0, 6), (1, 6, 12), (1, 12, 18)]


def test_closed_rounds_each_from_its_own_start_without_labels(read):
    run = read([*FORWARD, 360, *FORWARD, 360])
    assert shape(run) == [(1, 0, 6), (1, 7, 13)]
    assert run.series.round == (1, 2)


def test_there_and_back_without_labels(read):
    assert shape(read([*FORWARD, 360, *BACKWARD, 0])) == [(1, 0, 6), (-1, 7, 13)]
    run = read([*FORWARD, 360, *BACKWARD, 0, *FORWARD, 360])
    assert run.series.direction == (1, -1, 1)
    assert run.series.round == (1, 1, 2)
    # The turning point read once: it closes the way there, and the way back begins at the face before.
    assert shape(read([*FORWARD, 360, 300, 240, 180, 120, 60, 0])) == [(1, 0, 6), (-1, 7, -1)]
    assert shape(read([*FORWARD, *FORWARD[::-1]])) == [(1, 0, -1), (-1, 6, -1)]


def test_labels_say_where_a_series_ends(read):
    positions = [*FORWARD, 360, *BACKWARD, 0]
    both = read(positions, round=[1] * 14, direction=[1] * 7 + [-1] * 7)
    assert shape(both) == [(1, 0, 6), (-1, 7, 13)]
    assert both.series.round == (1, 1)
    assert shape(read(positions, round=[1] * 14)) == shape(both)
    assert shape(read(positions, direction=[1] * 7 + [-1] * 7)) == shape(both)
    # With labels a round that goes on where the last one stopped is not closed by it: x may have been set anew.
    turned_on = read([*FORWARD, *FORWARD], round=[1] * 6 + [2] * 6)
    assert shape(turned_on) == [(1, 0, -1), (1, 6, -1)]


def test_face_of_each_reading_and_reading_of_each_face(read):
    run = read([*FORWARD, 360, *BACKWARD, 0])
    assert run.face.tolist() == [0, 1, 2, 3, 4, 5, 0, 0, 5, 4, 3, 2, 1, 0]
    assert run.series.reading_of_face.tolist() == [[0, 1, 2, 3, 4, 5], [7, 12, 11, 10, 9, 8]]
    assert run.round.tolist() == [1] * 14
    assert run.direction.tolist() == [1] * 7 + [-1] * 7
    assert run.theta_deg.tolist() == [0, 60, 120, 180, 240, 300, 0, 0, 300, 240, 180, 120, 60, 0]


def test_face_1_is_the_one_read_first(read):
    run = read([183.2, 243.2, 303.2, 3.2, 63.2, 123.2])
    assert run.angle_deg == pytest.approx([183.2, 243.2, 303.2, 363.2, 423.2, 483.2])
    assert run.face.tolist() == [0, 1, 2, 3, 4, 5]
    backward = read([-0.0002, -60.0001, -120.0003, -180.0, -240.0, -300.0001])
    assert backward.angle_deg.tolist() == [0, 60, 120, 180, 240, 300]  # settings of a few arcsec are no angle
    assert backward.face.tolist() == [0, 5, 4, 3, 2, 1]


def test_each_series_may_begin_at_another_face(read):
    run = read([*FORWARD, 360, 120, 180, 240, 300, 0, 60, 120], round=[1] * 7 + [2] * 7)
    assert run.series.reading_of_face.tolist() == [[0, 1, 2, 3, 4, 5], [11, 12, 7, 8, 9, 10]]
    assert run.series.closing_reading.tolist() == [6, 13]


def test_counts_are_positions(read):
    run = read([round(2**23 * step / 6) for step in range(7)], name="count")
    assert run.position_deg == pytest.approx([60 * step for step in range(7)], abs=1e-4)
    assert shape(run) == [(1, 0, 6)]


@pytest.mark.parametrize("faces", [3, 4, 5])
def test_few_faces(read, faces):
    step = 360 / faces
    assert shape(read([step * face for face in range(faces + 1)], faces)) == [(1, 0, faces)]
    assert shape(read([-step * face for face in range(faces + 1)], faces)) == [(-1, 0, faces)]


def test_the_median_forgives_a_slip_in_the_first_row(read):
    with pytest.raises(Exception, match=r"row 3, column position_deg: 2.3 deg is 2.3 deg from the nearest face"):
        read([2.3, *FORWARD[1:]])


def test_weights_of_unlike_numbers(read):
    run = read([*FORWARD, *FORWARD, *BACKWARD], round=[1] * 6 + [2] * 6 + [3] * 6)
    assert run.series.weight.tolist() == [0.25, 0.25, 0.5]
    assert np.sum(read([*FORWARD, *FORWARD], round=[1] * 6 + [2] * 6).series.weight) == 1
