"""Parts of the kernel frame, filled in by each system: chosen by its type while compiling.

A system is a ``NamedTuple`` of numbers.  What differs between systems are functions, and a
function is picked by the system's class when a kernel is compiled for it: no call, no branch and
no table is left in the compiled kernel, which numba keeps on disk like any other.

    @part
    def begin(system, constants, state):
        "What a part has to do."

    @of(begin, Planar)
    def _(system, constants, state): ...

A lane's variables lie in the rows of a flat array; ``loader``, ``take`` and ``store`` move them to
and from the tuples that scalar functions work on.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any, TypeVar, cast

from llvmlite import ir
from numba import types
from numba.extending import intrinsic, overload

from mcsim.kernels.compilation import INLINED, apart, file_of
from mcsim.kernels.lanes import LANES

_Function = TypeVar("_Function", bound=Callable[..., Any])
_Maker = Callable[[type[Any]], Callable[..., Any]]
#: What fills in each part, by the class of the system.
PARTS: dict[Callable[..., Any], dict[type, _Maker]] = {}
_FILES: dict[type, set[Path]] = {}


def part(function: _Function) -> _Function:
    """Declare a part; its first parameter is the system."""
    PARTS[function] = {}

    def pick(system: Any) -> Callable[..., Any] | None:
        return implementation_of(function, class_of(system))

    # Numba compares the names of an overload's parameters with those of the function.
    names = parameters_of(function)
    scope = {"pick": pick}
    exec(f"def choose({', '.join(names)}):\n    return pick({names[0]})", scope)
    overload(function, jit_options=cast(Any, INLINED), strict=False)(scope["choose"])
    return function


def of(function: Callable[..., Any], system: type) -> Callable[[_Function], _Function]:
    """Fill in a part for a system, and for systems derived from it that have none of their own."""

    def add(implementation: _Function) -> _Function:
        _checked(function, implementation)
        PARTS[function][system] = lambda own: implementation
        _FILES.setdefault(system, set()).add(file_of(implementation))
        return implementation

    return add


def made(function: Callable[..., Any], system: type = object) -> Callable[[_Maker], _Maker]:
    """Declare what makes a part from a system's class; for every system unless one is given."""

    def add(maker: _Maker) -> _Maker:
        PARTS[function][system] = maker
        _FILES.setdefault(system, set()).add(file_of(maker))
        return maker

    return add


def implementation_of(function: Callable[..., Any], system: type[Any]) -> Callable[..., Any] | None:
    """What a system, or the nearest class that it is derived from, fills in for a part."""
    table = PARTS[function]
    for base in system.__mro__:
        if base in table:
            return _checked(function, table[base](system))
    return None


def _checked(function: Callable[..., Any], implementation: _Function) -> _Function:
    """Refuse an implementation whose parameters are not the part's: positions carry the meaning.

    Raises
    ------
    TypeError
        Other names, another order, or another number of parameters.
    """
    wanted, found = parameters_of(function), parameters_of(implementation)
    if wanted != found:
        raise TypeError(f"{function.__name__} takes {', '.join(wanted)}; not {', '.join(found)}")
    return implementation


def parameters_of(function: Callable[..., Any]) -> tuple[str, ...]:
    """Names of a function's parameters, in order."""
    # Of a compiled function, those of what it was compiled from.
    code = getattr(function, "py_func", function).__code__
    return tuple(code.co_varnames[: code.co_argcount])


@cache
def kernel_of(compiled: Any, system: type) -> Any:
    """A kernel of the frame for one system, kept in a file of its own.

    So an edit of a system's source leaves what is compiled for others as it is.
    """
    files = {file for base in system.__mro__ for file in _FILES.get(base, ())}
    return apart(compiled, system.__name__, *files)


def class_of(system: Any) -> type:
    """The Python class of a system's numba type."""
    found: type = getattr(system, "instance_class", type(None))
    return found


def loader(state: type[tuple[float, ...]]) -> Any:
    """Makes ``load(rows, j)``: lane ``j`` of the first rows of a flat array, as a named tuple."""

    @intrinsic
    def load(typing: Any, rows: Any, j: Any) -> Any:
        result = types.NamedUniTuple(rows.dtype, len(state._fields), state)  # type: ignore[attr-defined]

        def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            array, lane = arguments
            return _gather(context, builder, signature.args[0], array, lane, result)

        return result(rows, j), generate

    return load


def _take(typing: Any, rows: Any, j: Any, count: Any) -> Any:
    """Lane ``j`` of the first ``count`` rows of a flat array, as a tuple."""
    if not isinstance(count, types.IntegerLiteral):
        return None
    result = types.UniTuple(rows.dtype, count.literal_value)

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        array, lane, _ = arguments
        return _gather(context, builder, signature.args[0], array, lane, result)

    return result(rows, j, count), generate


def _store(typing: Any, rows: Any, j: Any, values: Any) -> Any:
    """Write a tuple into lane ``j`` of the first rows of a flat array."""
    if not isinstance(values, types.BaseTuple):
        return None

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        array, lane, items = arguments
        kind = signature.args[0]
        for row, source in enumerate(signature.args[2]):
            item = builder.extract_value(items, row)
            item = context.cast(builder, item, source, kind.dtype)
            address = _address(context, builder, kind, array, lane, row)
            builder.store(item, address)
        return context.get_dummy_value()

    return types.void(rows, j, values), generate


# Numba passes the typing context; callers see the other parameters.
take: Any = intrinsic(prefer_literal=True)(_take)
store: Any = intrinsic(_store)


def _gather(context: Any, builder: Any, kind: Any, array: Any, lane: Any, result: Any) -> Any:
    items = [
        builder.load(_address(context, builder, kind, array, lane, row))
        for row in range(result.count)
    ]
    return context.make_tuple(builder, result, items)


def _address(context: Any, builder: Any, kind: Any, array: Any, lane: Any, row: int) -> Any:
    data = context.make_array(kind)(context, builder, array).data
    offset = ir.Constant(lane.type, row * LANES)
    return builder.gep(data, [builder.add(lane, offset, flags=["nsw"])], inbounds=True)
