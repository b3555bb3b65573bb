"""Checks that `help` answers."""

import pydoc
from types import ModuleType

import map2aps
from docstrings import gaps
from map2aps._paths import Limits


def test_every_public_name_tells_what_it_takes_and_gives() -> None:
    assert gaps(map2aps) == []


def test_the_settings_of_a_trace_stand_where_help_shows_them() -> None:
    shown = pydoc.plain(pydoc.render_doc(map2aps.Tracer))
    for name in Limits.__annotations__:
        assert name in shown
    for default in ("3.5e9", "concrete", "2**30", "10,000,000", "20 by default"):
        assert default in shown


def test_what_a_docstring_lacks_is_told() -> None:
    def nothing(a: int) -> int:
        return a

    def half(a: int, *, b: int = 1) -> "npt.NDArray[np.float64]":  # type: ignore[name-defined]  # noqa: F821
        """Does.

        Parameters
        ----------
        a : int
        """

    class Silent:
        """Is."""

        def __init__(self, a: int) -> None: ...

        def forward(self, x: int) -> None: ...

        @property
        def of(self) -> int:
            return 1

        def __getitem__(self, i: int) -> int:
            """Takes.

            Parameters
            ----------
            i : int

            Returns
            -------
            int
            """
            return i

    module = ModuleType("m")
    module.__dict__.update(nothing=nothing, half=half, Silent=Silent, __all__=["nothing", "half", "Silent"])
    assert gaps(module) == [
        "m.nothing: no docstring",
        "m.half: b is not described",
        "m.half: Returns is missing",
        "m.half: no shape is told",
        "m.Silent: a is not described",
        "m.Silent.forward: no docstring",
        "m.Silent.of: no docstring",
    ]
