"""How a surface reflects: ambient, diffuse, specular, shininess, emission."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from typing import Any, Self

from pvphong.base import check, documents
from pvphong.base.types import ColorLike, InitSignature, rgb
from pvphong.optics.named_materials import NAMED, WITH_REFLECTANCE
from pvphong.optics.reflectance import Reflectance
from pvphong.optics.reflectances import REFLECTANCES
from pvphong.optics.reflectances.pbr import is_physical, physical_of

# A surface may be made to reflect more than all of the light, but whole numbers above this are 0-255 in disguise.
_MOST = 16.0


@dataclass(frozen=True, kw_only=True)
class Material:
    """A Phong material; the defaults are OpenGL's (2.1 specification, table 2.10).

    Parameters
    ----------
    ambient : color, default 0.2
        Reflectance of ambient light, k_ambient. A float (grey), RGB floats (1.0 = full), or a colour name.
    diffuse : color, default 0.8
        Reflectance of light that is scattered in all directions, k_diffuse.
    specular : color, default 0
        Reflectance of light that is mirrored in the highlight, k_specular.
    shininess : float, default 0
        Exponent of the highlight, >= 0; 1 to 200 is usual, 1e6 works.
    emission : color, default 0
        Light that the surface gives off by itself.
    reflectance : Reflectance, optional
        How it reflects; by the light model's `reflection` if not given.

    Raises
    ------
    ValueError
        If a field is out of range; the message names the field.
    """

    ambient: ColorLike = 0.2
    diffuse: ColorLike = 0.8
    specular: ColorLike = 0.0
    shininess: float = 0.0
    emission: ColorLike = 0.0
    reflectance: Reflectance | None = None

    __signature__ = InitSignature()

    def __new__(cls, *given: Any, **_fields: Any) -> Self:
        """Refuse what is given without a field's name: `Material("gold")` would be one of golden ambient light."""
        if given:
            check.refuse("Material", given[0], "given by its fields, as in Material(diffuse=...)", _remedy(given[0]))
        return super().__new__(cls)

    def __post_init__(self) -> None:
        for field in ("specular", "shininess"):
            if getattr(getattr(self, field), "size", 1) > 3:
                remedy = f"For one at each vertex, shade and evaluate take {field}=."
                check.refuse(field, "an array", "one for all vertices", remedy)
        for field in ("ambient", "diffuse", "specular", "emission"):
            object.__setattr__(self, field, check.color(field, getattr(self, field)))
        for field in ("ambient", "diffuse", "specular"):
            color = rgb(getattr(self, field))
            if _MOST < max(color) <= 255.0 and all(channel.is_integer() for channel in color):
                remedy = "These look like 0-255 values: divide them by 255."
                check.refuse(field, getattr(self, field), "a reflectance, of which 1.0 is all", remedy)
        object.__setattr__(self, "shininess", check.number("shininess", self.shininess, at_least=0.0))
        if self.reflectance is not None and not isinstance(self.reflectance, Reflectance):
            check.refuse(
                "reflectance",
                self.reflectance,
                "a reflectance, or None for the light model's",
                "For example, ph.GGX(roughness=0.3).",
            )

    @classmethod
    def named(cls, name: str) -> Self:
        """A material of some name; capitals do not count.

        "gold" and "red plastic" are among the classics of OpenGL teaching, with the light model's reflection;
        "metallic gold", "chalk" and "car paint" among those with a reflectance of their own.

        Raises
        ------
        ValueError
            If there is no such material; the message lists all, and suggests close matches.
        """
        known = check.choice("name", name.lower() if isinstance(name, str) else name, cls.names())
        if known in WITH_REFLECTANCE:
            return cls(**WITH_REFLECTANCE[known])
        ambient, diffuse, specular, shine = NAMED[known]
        return cls(ambient=ambient, diffuse=diffuse, specular=specular, shininess=shine * 128.0)

    @staticmethod
    def names() -> tuple[str, ...]:
        """The names that `named` knows."""
        return (*NAMED, *WITH_REFLECTANCE)

    def to_dict(self) -> dict[str, Any]:
        """Its fields as JSON can hold them; `from_dict` gives the material back to the last bit.

        A reflectance is a dictionary of its own fields and its "type"; it is left out where the light model's counts.

        Raises
        ------
        ValueError
            If the reflectance is of a kind that files do not know.
        """
        found = asdict(self)
        del found["reflectance"]
        if self.reflectance is not None:
            found["reflectance"] = documents.with_type("reflectance", self.reflectance, REFLECTANCES)
        return found

    @classmethod
    def from_dict(cls, given: Mapping[str, Any], place: str = "material") -> Self:
        """The material that `to_dict` gave.

        Parameters
        ----------
        given : mapping
            Field → value; fields that are not there have their defaults.
        place : str, default "material"
            What an error calls it.

        Raises
        ------
        ValueError
            If a field is unknown or not allowed.
        """
        found = documents.entries(place, given)
        if found.get("reflectance") is not None:
            inside = f"{place}.reflectance"
            found["reflectance"] = documents.value_of_type(inside, found["reflectance"], REFLECTANCES)
        return documents.value(place, cls, found)

    @classmethod
    def from_property(cls, prop: Any) -> Self:
        """The material of a `pyvista.Property` or `vtkProperty`, its colours unrounded.

        VTK keeps a coefficient and a colour for each term; their product is the reflectance. (VTK uses
        the ambient colour without a light's, as `LightModel.vtk()` does.) Where it is drawn with physically based
        shading (`pbr=True`), the material has the reflectance `PBR`.

        Raises
        ------
        ValueError
            If `prop` is not such an object, or uses what `PBR` has not; the message names it.
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
    def from_roughness(cls, roughness: float, **fields: Any) -> Self:
        """A material whose highlight falls off as (n·h)^(1/roughness), with Blinn-Phong reflection.

        Parameters
        ----------
        roughness : float
            0 < roughness <= 1, small is shiny; the shininess is 1/roughness.
        **fields
            The other fields of the material.
        """
        # below 2⁻¹⁰²² the reciprocal may be infinite
        roughness = check.number("roughness", roughness, at_least=2.0**-1022, at_most=1.0)
        return cls(**fields, shininess=1.0 / roughness)

    def for_blinn_phong(self) -> Self:
        """The material that looks the same with Blinn-Phong reflection: four times the shininess.

        The angle from n to h is about half the angle from r to v, and cos(x/2)^(4n) ≈ cos(x)^n.
        """
        return replace(self, shininess=4.0 * self.shininess)


def check_material(given: Any) -> None:
    """Raise ValueError unless it is a material."""
    if not isinstance(given, Material):
        check.refuse("material", given, "a Material", _remedy(given))


def nearest_in_vtk(material: Material) -> str:
    """A sentence that says what to take in place of a reflectance that VTK has not."""
    found = material.reflectance and material.reflectance.stand_in(material)
    if not found:
        return "Leave it out: VTK's is Phong's."
    _, instead = found
    shininess = instead.reflectance.of(instead).sharpness
    shown = [f"diffuse={_rounded(instead.diffuse)}", f"specular={_rounded(instead.specular)}"]
    return f"The nearest that VTK has is without it, {', '.join(shown)}, shininess={shininess:.4g}."


def _rounded(color: Any) -> str:
    return f"({', '.join(f'{channel:.4g}' for channel in rgb(color))})"


def _remedy(given: Any) -> str:
    """What gives a material, from what was taken for one."""
    if isinstance(given, str):
        is_one = given.lower() in Material.names()
        return f"Material.named({given!r})." if is_one else "Material.named knows those in Material.names()."
    return "Material.from_property makes one of a pyvista.Property."
