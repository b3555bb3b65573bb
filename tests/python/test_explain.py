import pickle
from pathlib import Path

import numpy as np
import pytest

import map2aps


def test_the_page_names_the_paths_of_a_link(scene: map2aps.Scene, paths: map2aps.Paths, tmp_path: Path) -> None:
    link = int(np.argmax(np.diff(paths.path_offset)))
    page = map2aps.explain(scene, paths, link)
    assert str(page).startswith("<!DOCTYPE html>") and "Lobes and paths" in str(page)
    assert page._repr_html_().startswith("<iframe srcdoc=")
    assert "A &amp; B" in str(map2aps.explain(scene, paths, link, "released", map2aps.UniformLinear(8), title="A & B"))
    page.save(tmp_path / "page.html")
    assert (tmp_path / "page.html").read_text(encoding="utf-8") == str(page)


def test_a_scene_of_other_buildings_is_refused(scene: map2aps.Scene, paths: map2aps.Paths) -> None:
    other = map2aps.Scene.synthetic(seed=4)
    link = int(np.argmax(np.diff(paths.path_offset)))
    changed = paths.replace(gain=0.5 * paths.gain)
    for traced in (paths, paths[link], paths[link:], changed, pickle.loads(pickle.dumps(paths))):
        at = 0 if len(traced) < len(paths) else link
        for call in (lambda: map2aps.explain(other, traced, at), lambda: map2aps.plot_link(traced, at, other)):
            with pytest.raises(ValueError, match="scene: its buildings are not those that the paths were traced in"):
                call()
        assert "Lobes and paths" in str(map2aps.explain(map2aps.Scene.synthetic(seed=3), traced, at))


def test_links_that_cannot_be_explained_are_named(scene: map2aps.Scene, paths: map2aps.Paths) -> None:
    nowhere = map2aps.Paths.from_arrays([0, 1], [1e-7], [0.1], [1e-4])
    with pytest.raises(ValueError, match="where the ends of link 0 are"):
        map2aps.explain(scene, nowhere)
    known = nowhere.replace(tx_m=paths.tx_m[:1], rx_m=paths.rx_m[:1])
    assert "Lobes and paths" in str(map2aps.explain(scene, known))
    for call in (map2aps.plot_link, lambda silent: map2aps.explain(scene, silent)):
        with pytest.raises(ValueError, match="link 0 receives no power"):
            call(known.replace(gain=[0.0]))
    for call in (lambda: map2aps.explain(scene, paths, 100), lambda: map2aps.plot_link(paths, 100), lambda: map2aps.plot_link(paths, -101)):
        with pytest.raises(IndexError, match="link: -?10[01] is none of 100 links"):
            call()
    with pytest.raises(ValueError, match="`old`"):
        map2aps.explain(scene, paths, 0, "old")
    for call, told in [
        (lambda: map2aps.explain(None, paths), "scene: expected Scene, got NoneType"),
        (lambda: map2aps.explain(scene, [1.0]), "paths: expected Paths, got list"),
        (lambda: map2aps.plot_link([1.0]), "paths: expected Paths, got list"),
        (lambda: map2aps.plot_link(paths, 0, [1.0]), "scene: expected Scene, got list"),
        (lambda: map2aps.plot_link(paths, 0, map2aps.Tracer(scene)), "scene: expected Scene, got Tracer"),
        (lambda: map2aps.plot_link(scene, paths), "paths: expected Paths, got Scene"),
    ]:
        with pytest.raises(TypeError, match=told):
            call()
    tracer = map2aps.Tracer(scene, max_reflections=0, max_diffractions=0)
    blocked = next(i for i in range(len(paths)) if len(tracer.trace(paths.tx_m[i], paths.rx_m[i]).delay_s) == 0)
    with pytest.raises(ValueError, match="no path"):
        map2aps.explain(scene, tracer.trace(paths.tx_m[blocked], paths.rx_m[blocked]))
