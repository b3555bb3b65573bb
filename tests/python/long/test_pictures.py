from pathlib import Path

import matplotlib
import numpy as np
import pytest

import map2aps

matplotlib.use("agg")


def test_a_table_has_a_row_a_path(paths: map2aps.Paths) -> None:
    table = paths.to_pandas()
    assert len(table) == len(paths.delay_s) and table["link"].max() < len(paths)
    straight = np.diff(paths.interaction_offset) == 0
    assert ((table["interactions"] == "LoS") == straight).all()
    first = int(np.flatnonzero(~straight)[0])
    event = paths.interaction_offset[first]
    assert table["interactions"][first].startswith(f"{'RD'[paths.interaction_kind[event]]}{paths.interaction_id[event]}")


def test_interactions_that_are_not_known_are_no_line_of_sight(paths: map2aps.Paths) -> None:
    foreign = map2aps.Paths.from_arrays(paths.path_offset, paths.delay_s, paths.arrival_azimuth_rad, paths.gain)
    assert (foreign.to_pandas()["interactions"] == "?").all()
    # Where the ends are known, the path that is as long as the link is the straight one.
    known = foreign.replace(tx_m=paths.tx_m, rx_m=paths.rx_m).to_pandas()["interactions"]
    straight = np.diff(paths.interaction_offset) == 0
    longer = paths.delay_s * 3e8 > 1.001 * np.hypot(*(paths.tx_m - paths.rx_m).T)[paths.link] + 0.01
    assert straight.any() and longer.sum() > 500 and (known[straight] == "LoS").all() and (known[longer] == "?").all()
    assert len(map2aps.Paths.from_arrays([0, 0], [], [], []).to_pandas()) == 0


def test_a_link_is_drawn_with_its_paths_and_walls(scene: map2aps.Scene, paths: map2aps.Paths, tmp_path: Path) -> None:
    link = int(np.argmax(np.diff(paths.path_offset)))
    axes = map2aps.plot_link(paths, link, scene)
    assert len(axes.lines) == len(scene.walls) + len(paths[link].delay_s) + 2
    axes.figure.savefig(tmp_path / "link.png")
    with pytest.raises(ValueError, match="where the ends of link 0 are"):
        map2aps.plot_link(map2aps.Paths.from_arrays([0, 1], [1e-7], [0.1], [1e-4]))
    assert len(map2aps.plot_link(paths, link, ax=axes).lines) == len(scene.walls) + 2 * len(paths[link].delay_s) + 4


def test_a_bar_shows_the_progress(tmp_path: Path, capsys: object) -> None:
    assert map2aps.make_dataset(tmp_path / "set", 1, tx_per_map=1, rx_per_map=5, progress=True).links == 5
    assert "5.00/5.00" in capsys.readouterr().err  # type: ignore[attr-defined]
