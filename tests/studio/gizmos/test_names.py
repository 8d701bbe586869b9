"""Names that no other light has."""

import pytest

from pvphong.studio.gizmos.names import free_name


@pytest.mark.parametrize(
    ("wanted", "taken", "name"),
    [
        ("lamp", [], "lamp"),
        ("lamp", ["lamp"], "lamp 2"),
        ("lamp", ["lamp", "lamp 2", "lamp 4"], "lamp 3"),
        ("lamp 2", ["lamp", "lamp 2"], "lamp 3"),
        ("lamp 7", ["lamp"], "lamp 7"),
    ],
)
def test_a_name_is_kept_where_it_is_free_and_numbered_where_not(wanted, taken, name):
    assert free_name(wanted, taken) == name
