"""Parts of the kernel frame: every system fills them in, with the parameters that they declare."""

import pytest

from mcsim.kernels import frame, parts
from mcsim.kernels.parts import made, of, part
from mcsim.systems import SYSTEMS

KERNELS = [case.kernel() for case in SYSTEMS.values() if case.kernel is not None]


@part
def push(system, force, rows):
    """A part of this test."""


@pytest.mark.parametrize("kernel", KERNELS, ids=lambda kernel: kernel.__name__)
def test_every_part_has_an_implementation_with_its_parameters(kernel):
    assert frame.simulate is not None  # the frame, with all its parts, is there
    for declared in set(parts.PARTS) - {push}:
        implementation = parts.implementation_of(declared, kernel)
        assert implementation is not None, declared.__name__
        assert parts.parameters_of(implementation) == parts.parameters_of(declared)


def test_positions_cannot_be_mistaken():
    class Sled:
        pass

    with pytest.raises(TypeError, match="push takes system, force, rows; not system, rows, force"):

        @of(push, Sled)
        def _(system, rows, force):
            pass

    @made(push, Sled)
    def _make(system):
        return lambda system, force: None

    with pytest.raises(TypeError, match="not system, force"):
        parts.implementation_of(push, Sled)
    assert parts.implementation_of(push, type("Another", (), {})) is None
