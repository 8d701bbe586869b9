"""Materials: ambient, diffuse, specular, shininess, emission, maps and reflectance."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from functools import partial
from typing import Any, Self

import numpy as np

from pvphong.base import check, documents, host
from pvphong.base.types import InitSignature, rgb
from pvphong.optics.colormap import Colormap
from pvphong.optics.maps import (
    COLORS,
    FIELDS,
    MOST_REFLECTED,
    AnyMap,
    Map,
    NamedColor,
    color_or_map,
    is_color_name,
    is_texture,
    number_or_map,
    refuse_unnamed,
)
from pvphong.optics.named_materials import NAMED, WITH_REFLECTANCE
from pvphong.optics.reflectance import Reflectance
from pvphong.optics.reflectances import REFLECTANCES
from pvphong.optics.reflectances.likeness import LIKENESS, stand_in
from pvphong.optics.reflectances.pbr import is_physical, physical_of

# Fields that files of earlier versions lack, and their defaults. Without them, earlier versions can read a file.
_NEW = (("albedo", 1.0), ("tangents", None), ("reflectance", None))


def _reflected(name: str, value: Any, *, checked: check.Check = color_or_map, is_part: bool = False) -> Any:
    """Check the value of a field that is a reflectance, refuse 0-255 values, and return it in canonical form.

    Parameters
    ----------
    name : str
        Name of the field.
    value : Any
        A colour or, if `checked` allows it, a map. Numbers in maps are checked later.
    checked : callable
        Check of the field, which is called with name and value.
    is_part : bool
        True if the field is a fraction of the light, so that values above 1 are refused.
    """
    found = checked(name, value)
    most = 1.0 if is_part else MOST_REFLECTED
    if not isinstance(found, AnyMap) and max(rgb(found)) > most:
        is_255 = max(rgb(found)) <= 255.0 and all(channel.is_integer() for channel in rgb(found))
        if is_255 or is_part:
            remedy = "These look like 0-255 values: divide them by 255." if is_255 else ""
            check.refuse(name, found, f"a reflectance{' of at most 1.0' * is_part}, where 1.0 is all light", remedy)
    return found


def _vectors(_name: str, value: Any) -> Any:
    return value if value is None or isinstance(value, str | Map) else Map(value)


def _reflectance(name: str, value: Any) -> Any:
    if value is None or isinstance(value, Reflectance):
        return value
    allowed = "a reflectance, or None to use the light model's `reflection`"
    return check.refuse(name, value, allowed, "For example, ph.GGX(roughness=0.3).")


@dataclass(frozen=True, kw_only=True)
class Material:
    """Phong material with OpenGL's defaults (2.1 specification, table 2.10), except for the shininess.

    A colour is a float (grey), RGB floats (1.0 = full), or a colour's name.

    A map gives a value for each vertex. It is one of:

    - the name of a point array of the mesh;
    - an array with a row for each vertex;
    - a `pyvista.Texture` or the path of an image file, for a mesh with texture coordinates;
    - for colours, a `Colormap`: a scalar array mapped through a colormap.

    uint8 colours in a map are divided by 255. In a texture of shininess, white means 128, OpenGL's largest value. For a
    field that may be a colour or a map, a string that is a colour's name means that colour, and three numbers mean one
    colour.

    Parameters
    ----------
    ambient : color, default 0.2
        Reflectance of ambient light, k_ambient.
    diffuse : color or map, default 0.8
        Reflectance of diffusely scattered light, k_diffuse.
    specular : color or map, default 0
        Reflectance of light in the highlight, k_specular.
    shininess : float or map, default 30
        Exponent of the highlight, >= 0; 1 to 200 is usual, and 1e6 works. The default is the same as in three.js and
        Mitsuba. With OpenGL's default, 0, there is no highlight: `specular` is added to all surfaces that face a light.
        VTK's default is 1.
    emission : color or map, default 0
        Light that the surface emits.
    albedo : color or map, default 1
        Multiplies `ambient` and `diffuse`. Floats of a map are clipped to [0, 1]; NaN becomes 0.
    tangents : str or array_like, optional
        Vectors along the surface, for an anisotropic reflectance: the name of a point array, or an array of shape
        (n, 3). By default, they follow the mesh's texture coordinate u.
    reflectance : Reflectance, optional
        Reflectance; defaults to the light model's `reflection`. Its roughness, metallic or shininess may also be maps.

    Raises
    ------
    ValueError
        If a field is out of range; the message names the field.

    Examples
    --------
    >>> import pyvista as pv, pvphong as ph
    >>> paint = ph.Material(diffuse=(0.8, 0.1, 0.1), specular=0.4, shininess=50)
    >>> lit = pv.Sphere().phong.shade(material=paint)
    >>> ph.Material.named("gold").shininess
    51.2
    """

    ambient: Any = check.field(partial(_reflected, checked=check.color), 0.2)
    diffuse: Any = check.field(_reflected, 0.8)
    specular: Any = check.field(_reflected, 0.0)
    shininess: Any = check.field(partial(number_or_map, at_least=0.0), 30.0)
    emission: Any = check.field(color_or_map, 0.0)
    albedo: Any = check.field(partial(_reflected, is_part=True), 1.0)
    tangents: Any = check.field(_vectors, None)
    reflectance: Reflectance | None = check.field(_reflectance, None)

    __signature__ = InitSignature()

    def __new__(cls, *given: Any, **fields: Any) -> Self:
        """Raise an error for unknown fields and for positional arguments.

        Otherwise `Material("gold")` would set the ambient colour.
        """
        if given:
            check.refuse("Material", given[0], "made with keywords, as in Material(diffuse=...)", _remedy(given[0]))
        check.refuse_color(cls, fields)
        check.keywords(cls, fields)
        return super().__new__(cls)

    def __repr__(self) -> str:
        shown = [f"{each.name}={getattr(self, each.name)!r}" for each in fields(self) if each.name not in self._unset]
        return f"Material({', '.join(shown)})"

    @property
    def _unset(self) -> list[str]:
        """Names of the fields that scene files and `repr` omit.

        These fields have their default value, and scene files of earlier versions do not have them.
        """
        return [name for name, default in _NEW if getattr(self, name) == default]

    def __post_init__(self) -> None:
        check.fields(self)

    @property
    def maps(self) -> dict[str, AnyMap]:
        """Maps of this material and of its reflectance, as name of the field → map.

        If the reflectance sets a field, such as the shininess, the reflectance's value counts, even if the material's
        own value is a map.
        """
        own = {name: getattr(self, name) for name in (*COLORS, "shininess")}
        of = vars(self.reflectance) if self.reflectance is not None else {}
        own |= {name: value for name, value in of.items() if name in FIELDS and value is not None}
        return {name: value for name, value in own.items() if isinstance(value, AnyMap)}

    def with_values(self, values: Mapping[str, Any]) -> Self:
        """Return a copy in which some fields have new values.

        `values` maps names of fields to values. A field that the material's reflectance sets, such as its shininess, is
        replaced in the reflectance, any other field in the material.
        """
        of = self.reflectance
        inner = {name: value for name, value in values.items() if getattr(of, name, None) is not None}
        changes: dict[str, Any] = {name: value for name, value in values.items() if name not in inner}
        if of is not None and inner:
            changes["reflectance"] = replace(of, **inner)
        return replace(self, **changes) if changes else self

    def without_albedo(self) -> Self:
        """Return an equivalent material with an albedo of 1: ambient and diffuse are multiplied by the albedo.

        Neither albedo, ambient nor diffuse may be a map.
        """
        if self.albedo == 1.0:
            return self
        albedo = rgb(self.albedo)
        colors: dict[str, Any] = {
            name: tuple(a * b for a, b in zip(albedo, rgb(getattr(self, name)), strict=True))
            for name in ("ambient", "diffuse")
        }
        return replace(self, albedo=1.0, **colors)

    @classmethod
    def named(cls, name: str) -> Self:
        """Return a material by its name, case-insensitive.

        "gold" and "red plastic" are among the classic materials of OpenGL teaching. The classic materials use the light
        model's reflection; "metallic gold", "chalk" and "car paint" have their own reflectance.

        Raises
        ------
        ValueError
            If there is no such material; the message lists all names, and suggests close matches.
        """
        known = check.choice("name", name.lower() if isinstance(name, str) else name, cls.names())
        if known in WITH_REFLECTANCE:
            return cls(**WITH_REFLECTANCE[known])
        ambient, diffuse, specular, shine = NAMED[known]
        return cls(ambient=ambient, diffuse=diffuse, specular=specular, shininess=shine * 128.0)

    @staticmethod
    def names() -> tuple[str, ...]:
        """Return the names for `named`."""
        return (*NAMED, *WITH_REFLECTANCE)

    def to_dict(self) -> dict[str, Any]:
        """Return the material's fields as a dictionary for JSON; `from_dict` restores the material exactly.

        A reflectance becomes a dictionary of its fields and its "type". The entry is omitted if the material has none.

        Raises
        ------
        ValueError
            If the reflectance has a user-defined type, or a map is not a name.
        """
        left_out = (*self._unset, "reflectance")
        found = {each.name: getattr(self, each.name) for each in fields(self) if each.name not in left_out}
        for name, value in (found | self.maps).items():
            refuse_unnamed(name, value)
        found |= {name: each.name for name, each in found.items() if isinstance(each, NamedColor)}
        found |= {name: each.to_dict(name) for name, each in found.items() if isinstance(each, Colormap)}
        if self.reflectance is not None:
            found["reflectance"] = documents.with_type("reflectance", self.reflectance, REFLECTANCES)
        return found

    @classmethod
    def from_dict(cls, given: Mapping[str, Any], place: str = "material") -> Self:
        """Restore a material from `to_dict`.

        Parameters
        ----------
        given : mapping
            Values by field; missing fields have their defaults.
        place : str, default "material"
            Name of the material in error messages.

        Raises
        ------
        ValueError
            If a field is unknown or not allowed.
        """
        found = documents.entries(place, given)
        for name in COLORS:
            if isinstance(found.get(name), Mapping):
                found[name] = Colormap.from_dict(found[name], f"{place}.{name}")
        if found.get("reflectance") is not None:
            inside = f"{place}.reflectance"
            found["reflectance"] = documents.value_of_type(inside, found["reflectance"], REFLECTANCES)
        return documents.value(place, cls, found)

    @classmethod
    def from_property(cls, prop: Any) -> Self:
        """Make the material of a `pyvista.Property` or `vtkProperty`, its colours unrounded.

        VTK stores a coefficient and a colour for each term; their product is the reflectance. (Neither VTK nor
        `LightModel.vtk()` multiplies the ambient colour by a light's colour.) With physically based shading
        (`pbr=True`), the material has the reflectance `PBR`.

        If a mesh has its own colours, VTK draws them in place of the property's; `from_actor` reads them.

        Raises
        ------
        ValueError
            If `prop` is not a property, or uses a feature that `PBR` does not support; the message names the feature.
        """
        if not hasattr(prop, "GetSpecularPower"):
            check.refuse("prop", prop, "a pyvista.Property or a vtkProperty")
        terms = {
            "ambient": (prop.GetAmbient(), prop.GetAmbientColor()),
            "diffuse": (prop.GetDiffuse(), prop.GetDiffuseColor()),
            "specular": (prop.GetSpecular(), prop.GetSpecularColor()),
        }
        colors: dict[str, Any] = {term: tuple(k * c for c in color) for term, (k, color) in terms.items()}
        reflectance = physical_of(prop) if is_physical(prop) else None
        return cls(**colors, shininess=prop.GetSpecularPower(), reflectance=reflectance)

    @classmethod
    def from_actor(cls, actor: Any) -> Self:
        """Make the material of a `pyvista.Actor` or `vtkActor`, from its property and the colours of its mesh.

        Vertex colours, scalars through a colormap, or a texture become the albedo. VTK draws vertex colours and scalars
        in place of the property's ambient and diffuse colours; it keeps the property's ambient and diffuse
        coefficients. With vertex colours or scalars, the albedo is an array with a row for each point or cell that the
        actor draws.

        Parameters
        ----------
        actor : pyvista.Actor or vtkActor
            Actor, as from `plotter.add_mesh`. It is not modified.

        Raises
        ------
        ValueError
            If `actor` is not an actor, or as for `from_property`.
        """
        if not (hasattr(actor, "GetProperty") and hasattr(actor, "GetMapper")):
            check.refuse("actor", actor, "a pyvista.Actor or a vtkActor", "plotter.add_mesh returns one.")
        prop, mapper, texture = actor.GetProperty(), actor.GetMapper(), actor.GetTexture()
        found = cls.from_property(prop)
        albedo = host.answers().mapper_colors(mapper)
        if albedo is not None:
            return replace(found, ambient=prop.GetAmbient(), diffuse=prop.GetDiffuse(), albedo=albedo)
        return found if texture is None else replace(found, albedo=texture)

    @classmethod
    def from_roughness(cls, roughness: float, **fields: Any) -> Self:
        """Make a material whose highlight is (n·h)^(1/roughness) with Blinn-Phong reflection.

        Parameters
        ----------
        roughness : float
            0 < roughness <= 1; small values are shiny. The shininess is 1/roughness.
        **fields
            The other fields of the material.
        """
        # below 2⁻¹⁰²² the reciprocal may be infinite
        roughness = check.number("roughness", roughness, at_least=2.0**-1022, at_most=1.0)
        return cls(**fields, shininess=1.0 / roughness)

    def for_blinn_phong(self) -> Self:
        """Return a material that looks about the same with Blinn-Phong reflection: its shininess is four times as high.

        The angle from n to h is about half the angle from r to v, and cos(x/2)^(4n) ≈ cos(x)^n.

        Raises
        ------
        ValueError
            If the shininess is a map.
        """
        if isinstance(self.shininess, str | Map):
            check.refuse("shininess", self.shininess, "one number", "Multiply the map by 4.")
        return replace(self, shininess=LIKENESS * self.shininess)


DEFAULT_MATERIAL = Material()
"""Material of meshes without one: OpenGL's default material."""


def as_material(given: Any) -> Material:
    """Return a material unchanged, or the material with a given name.

    Raises
    ------
    ValueError
        If `given` is neither a material nor a material's name; the message suggests how to make a material from it.
    """
    if isinstance(given, Material):
        return given
    names = Material.names()
    if isinstance(given, str) and given.lower() in names:
        return Material.named(given)
    allowed = "a Material or the name of a material"
    if is_texture(given):
        remedy = "Use Material(albedo=texture)."
    elif isinstance(given, str) and not is_color_name(given):
        remedy = check.meant(given, names) or "Material.names() lists the names."
    elif isinstance(given, tuple | list) and any(isinstance(each, str | Material) for each in given):
        remedy = "For blocks, pass a mapping from their names: dict(zip(blocks.keys(), materials))."
    elif isinstance(given, str | tuple | list) or hasattr(given, "float_rgb"):
        remedy = f"For a colour, use Material(diffuse={given!r})."
    else:
        remedy = "Convert a pyvista.Property with Material.from_property."
    return check.refuse("material", given, allowed, remedy)


def without_maps(material: Material, where: str) -> Material:
    """Return an equivalent material with an albedo of 1; raise ValueError if a field of the material is a map.

    `where` ends the message; it says where maps are not allowed, as in "for VTK's picture".
    """
    for name, given in material.maps.items():
        check.refuse(name, given, f"one number or colour {where}")
    return material.without_albedo()


def refuse_maps_in_vtk(material: Material) -> None:
    """Raise ValueError for maps that VTK cannot draw, because VTK has one property for a whole mesh.

    Only a map of the albedo can be drawn, as vertex colours. The map must then be uint8, `ambient` and `diffuse` must
    be grey, and the material must have neither an emission nor a reflectance.
    """
    for name, given in material.maps.items():
        if name != "albedo":
            remedy = "VTK's shader takes one value per mesh; only an albedo can be a map, as vertex colours."
            check.refuse(name, given, "one number or colour, for a comparison with VTK", remedy)
    if "albedo" not in material.maps:
        return
    if np.asarray(material.albedo).dtype != np.uint8:
        remedy = "Convert it with np.rint(255 * colours).astype(np.uint8)."
        check.refuse("albedo", "a map of floats", "uint8, as VTK's vertex colours are", remedy)
    for name in ("ambient", "diffuse"):
        red, green, blue = rgb(getattr(material, name))
        if not red == green == blue:
            check.refuse(name, getattr(material, name), "grey if albedo is a map and the result is compared with VTK")
    if any(rgb(material.emission)) or material.reflectance is not None:
        name = "reflectance" if material.reflectance is not None else "emission"
        allowed = "left out if albedo is a map and the result is compared with VTK"
        check.refuse(name, getattr(material, name), allowed)


def nearest_in_vtk(material: Material) -> str:
    """Return a sentence that suggests a replacement for a material's reflectance that VTK does not support."""
    found = material.reflectance and stand_in(material.reflectance, material)
    if not found:
        return "Leave it out; VTK's reflectance is Phong's."
    _, instead = found
    shininess = instead.reflectance.of(instead).sharpness
    shown = [f"diffuse={_rounded(instead.diffuse)}", f"specular={_rounded(instead.specular)}"]
    return f"The nearest material in VTK has reflectance=None, {', '.join(shown)}, shininess={shininess:.4g}."


def _rounded(color: Any) -> str:
    return f"({', '.join(f'{channel:.4g}' for channel in rgb(color))})"


def _remedy(given: Any) -> str:
    """Return a sentence that suggests another call after `Material(given)` was refused.

    `Material` has only keyword arguments.
    """
    if isinstance(given, str) and given.lower() in Material.names():
        return f"Use Material.named({given!r})."
    return "Convert a pyvista.Property with Material.from_property."
