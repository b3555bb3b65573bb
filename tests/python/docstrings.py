"""Checks docstrings in NumPy's style."""

import inspect
import re
from collections.abc import Iterator
from types import FunctionType, ModuleType
from typing import Any

from map2aps._paths import Limits

# Those that need no sections.
SHORT = ("__len__", "__iter__")
# Nobody else makes one.
MADE_BY_THE_PACKAGE = ("Map",)


def section(doc: str, title: str) -> list[str]:
    """Lines of a section."""
    found = re.search(rf"^{title}\n-+\n(.*?)(?=\n\n\S.*\n-+\n|\Z)", doc, re.MULTILINE | re.DOTALL)
    return found[1].splitlines() if found else []


def names(doc: str, *titles: str) -> set[str]:
    """Names that sections describe."""
    lines = [line for title in titles for line in section(doc, title)]
    heads = [line.partition(" : ")[0] for line in lines if line and not line[0].isspace()]
    return {name for head in heads for name in head.split(", ")}


def wanted(of: Any) -> set[str]:
    """Names of what a callable takes."""
    try:
        parameters = list(inspect.signature(of).parameters.values())
    except ValueError:
        # A native class without a constructor.
        return set()
    stars = {inspect.Parameter.VAR_KEYWORD: "**", inspect.Parameter.VAR_POSITIONAL: "*"}
    return {stars.get(one.kind, "") + one.name for one in parameters if one.name != "self"}


def lacks(of: Any, doc: str, *titles: str) -> set[str]:
    """Lists the parameters that no section describes; the settings of a trace may stand for themselves."""
    described = names(doc, *titles)
    if set(Limits.__annotations__) <= described:
        described.add("**limits")
    return wanted(of) - described


def of_function(name: str, of: Any) -> Iterator[str]:
    doc = inspect.getdoc(of) or ""
    # Where it is written, not where it is inherited from.
    if not of.__doc__:
        yield f"{name}: no docstring"
        return
    if name.rpartition(".")[2] in SHORT:
        return
    for parameter in sorted(lacks(of, doc, "Parameters")):
        yield f"{name}: {parameter} is not described"
    # Native ones, whose annotations are elsewhere, all return something.
    returned = inspect.signature(of).return_annotation
    if returned not in ("None", None) and not section(doc, "Returns"):
        yield f"{name}: Returns is missing"
    yield from of_arrays(name, returned, doc)


def of_arrays(name: str, returned: object, doc: str) -> Iterator[str]:
    if re.search("NDArray|Tensor", str(returned)) and "shape" not in doc:
        yield f"{name}: no shape is told"


def of_property(name: str, of: Any) -> Iterator[str]:
    doc = inspect.getdoc(of) or ""
    if not doc:
        yield f"{name}: no docstring"
    elif isinstance(of, property):
        yield from of_arrays(name, inspect.signature(of.fget).return_annotation, doc)


def of_class(name: str, of: type) -> Iterator[str]:
    if not of.__doc__:
        yield f"{name}: no docstring"
        return
    if of.__name__ not in MADE_BY_THE_PACKAGE:
        for parameter in sorted(lacks(of, inspect.getdoc(of) or "", "Parameters", "Attributes")):
            yield f"{name}: {parameter} is not described"
    for own, value in vars(of).items():
        is_shown = not own.startswith("_") or own in (*SHORT, "__getitem__", "__getitems__")
        if isinstance(value, FunctionType | classmethod | staticmethod) or inspect.ismethoddescriptor(value):
            if is_shown and not (own in SHORT and not isinstance(value, FunctionType)):
                yield from of_function(f"{name}.{own}", getattr(of, own))
        elif is_shown and (isinstance(value, property) or inspect.isgetsetdescriptor(value)):
            yield from of_property(f"{name}.{own}", value)


def gaps(module: ModuleType) -> list[str]:
    """Lists the faults in the docstrings of a module's public names."""
    found: list[str] = []
    for name in module.__all__:
        of, full = getattr(module, name), f"{module.__name__}.{name}"
        if inspect.isclass(of):
            found += of_class(full, of)
        elif callable(of):
            found += of_function(full, of)
    return found
