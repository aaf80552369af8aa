"""Lists of parts: order, names, what is imported later, and what is said of unknown names."""

from __future__ import annotations

from dataclasses import dataclass

import pytest

from mcsim.errors import InputError
from mcsim.registry import Registry


@dataclass(frozen=True)
class Fruit:
    name: str


def test_parts_keep_their_order_and_their_names():
    fruits = Registry("fruit", [Fruit("pear"), Fruit("apple")])
    fruits.add(Fruit("plum"))
    assert list(fruits) == ["pear", "apple", "plum"]
    assert fruits["apple"] == Fruit("apple")


@pytest.mark.parametrize("name", ["apple", "", None])
def test_a_name_is_taken_once(name):
    fruits = Registry("fruit", [Fruit("apple")])
    with pytest.raises(InputError):
        fruits.add(Fruit(name))
    assert list(fruits) == ["apple"]


def test_what_is_unknown_is_told_with_what_is_known():
    fruits = Registry("fruit", [Fruit("apple"), Fruit("pear")])
    with pytest.raises(InputError, match=r'basket: "aple" is not a fruit .*mean "apple"'):
        fruits.find("aple", "basket: ")


def test_costly_parts_are_imported_when_looked_up():
    parts = Registry("number", later={"pi": "math:pi", "nothing": "no_such_module:x"})
    assert list(parts) == ["pi", "nothing"]
    assert parts["pi"] == 3.141592653589793
    with pytest.raises(ModuleNotFoundError):
        parts["nothing"]


def test_who_listens_hears_before_a_part_is_listed():
    fruits = Registry("fruit", [Fruit("apple")])

    def refuse(fruit: Fruit) -> None:
        raise InputError(f"{fruit.name}: not ripe")

    fruits.tell(refuse)
    with pytest.raises(InputError, match="not ripe"):
        fruits.add(Fruit("pear"))
    assert "pear" not in fruits
