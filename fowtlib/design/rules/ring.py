"""Ring frames of a cylindrical shell, T-shaped and inside, DNV-RP-C202 (2013), sections 3.5 and 3.10."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from fowtlib.design.rules.either import demand, larger, of_arrays, size, smaller, sqrt
from fowtlib.design.rules.shell import hoop_stress
from fowtlib.design.rules.steel import STEEL, Steel


@dataclass(frozen=True)
class Ring:
    """Web height and thickness, flange width and thickness, spacing of the rings [m]."""

    web_height: Any
    web_thickness: Any
    flange_width: Any
    flange_thickness: Any
    spacing: Any

    @property
    def area(self) -> Any:
        """Area of the section, without shell [m^2]."""
        return self.web_height * self.web_thickness + self.flange_width * self.flange_thickness

    def flange_radius(self, radius: Any, thickness: Any) -> Any:
        """Radius of the inner face of the flange [m] in a shell of this radius of the middle of the wall."""
        return radius - thickness / 2 - self.web_height - self.flange_thickness

    def demand_in(self, radius: Any, thickness: Any) -> None:
        """ModelError for sizes that are not above zero, or a ring that does not fit into this shell."""
        demand("a ring", 0.0, web_height=self.web_height, web_thickness=self.web_thickness,
               flange_width=self.flange_width, flange_thickness=self.flange_thickness, spacing=self.spacing,
               flange_radius=self.flange_radius(radius, thickness))  # fmt: skip

    def centroid_radius(self, radius: Any, thickness: Any) -> Any:
        """Radius of the centroid of the ring without shell [m]."""
        web = self.web_height * self.web_thickness * self.web_height / 2
        flange = self.flange_width * self.flange_thickness * (self.web_height + self.flange_thickness / 2)
        return radius - thickness / 2 - (web + flange) / self.area


@dataclass(frozen=True)
class RingSection:
    """A ring with its effective width of shell: width [m], radius of the centroid [m], inertia [m^4], edge [m].

    edge: from the centroid to the outer edge of the flange.
    """

    width: Any
    centroid_radius: Any
    inertia: Any
    edge: Any


def ring_section(ring: Ring, radius: Any, thickness: Any) -> RingSection:
    """Ring with the smaller of its spacing and 1.56 sqrt(r t)/(1 + 12 t/r) of shell (3.5.3); kink between the two."""
    width = smaller(ring.spacing, 1.56 * sqrt(radius * thickness) / (1 + 12 * thickness / radius))
    inner = radius - thickness / 2
    parts = [  # area, radius of the centroid, height
        (width * thickness, radius, thickness),
        (ring.web_height * ring.web_thickness, inner - ring.web_height / 2, ring.web_height),
        (ring.flange_width * ring.flange_thickness, inner - ring.web_height - ring.flange_thickness / 2,
         ring.flange_thickness),
    ]  # fmt: skip
    centroid = sum(A * at for A, at, _ in parts) / sum(A for A, _, _ in parts)
    inertia = sum(A * (at - centroid) ** 2 + A * height**2 / 12 for A, at, height in parts)
    return RingSection(width, centroid, inertia, centroid - ring.flange_radius(radius, thickness))


@dataclass(frozen=True)
class PanelRing:
    """Utilisations [-] of a ring frame: area, inertia, stress at the flange, web, flange, torsion; and what they need.

    required_area [m^2], required_inertia [m^4], section, flange_stress [Pa].
    """

    area: Any
    inertia: Any
    stress: Any
    web: Any
    flange: Any
    torsion: Any
    required_area: Any
    required_inertia: Any
    flange_stress: Any
    section: RingSection


@of_arrays
def panel_ring(
    ring: Ring, radius: Any, thickness: Any, longitudinal_stress: Any, external_pressure: Any, *,
    shear_stress: Any = 0.0, length: Any = None, out_of_roundness: Any = 0.005, steel: Steel = STEEL,
) -> PanelRing:  # fmt: skip
    """Panel ring buckling and local buckling of a T-ring inside a shell.

    Area: A_R >= (2/Z^2 + 0.06) l t. Inertia: I_R >= I_x + I_xh + I_h with I_x = |sigma_x| t r_0^4/(500 E l),
    I_xh = (tau/E)^(8/5) (r_0/L)^(1/5) L r_0 t l and I_h = |p| r r_0^2 l/(3 E) [1.5 + 3 E z_t delta_0/(r_0^2 (f_y/2 -
    |sigma_hR|))] (3.5.2). Stress: |sigma_hR| <= f_y/2, without which I_h has no meaning; beyond 0.495 f_y it is that of
    0.495 f_y (a kink), large and positive. Web h <= 1.35 t_w sqrt(E/f_y), flange b/2 <= 0.4 t_f sqrt(E/f_y), torsion
    b >= 7 h/sqrt(10 + E h/(f_y r)) (3.10).
    longitudinal_stress [Pa]: of axial force and bending, positive in tension; external_pressure [Pa]; shear_stress
    [Pa] needs the length L [m] between bulkheads or other heavy rings; out_of_roundness: delta_0/r.
    """
    ring.demand_in(radius, thickness)
    E, fy, r, t, spacing = steel.youngs_modulus, steel.yield_stress, radius, thickness, ring.spacing
    section, A = ring_section(ring, r, t), ring.area
    hoop = hoop_stress(external_pressure, longitudinal_stress, r, t, spacing, A, ring.flange_radius(r, t), steel)
    r0, held = section.centroid_radius, size(hoop.at_ring)
    reserve = fy / 2 - smaller(held, 0.495 * fy)
    inertia = size(longitudinal_stress) * t * r0**4 / (500 * E * spacing)
    bent = 1.5 + 3 * E * section.edge * out_of_roundness * r / (r0**2 * reserve)
    inertia = inertia + size(external_pressure) * r * r0**2 * spacing / (3 * E) * bent
    if length is not None:
        tau = larger(size(shear_stress), 1e-12 * E)
        inertia = inertia + (tau / E) ** 1.6 * (r0 / length) ** 0.2 * length * r0 * t * spacing
    Z = spacing**2 / (r * t) * sqrt(1 - steel.poissons_ratio**2)
    area, slender = (2 / Z**2 + 0.06) * spacing * t, sqrt(E / fy)
    return PanelRing(
        area / A,
        inertia / section.inertia,
        held / (fy / 2),
        ring.web_height / (1.35 * ring.web_thickness * slender),
        ring.flange_width / 2 / (0.4 * ring.flange_thickness * slender),
        7 * ring.web_height / sqrt(10 + E / fy * ring.web_height / r) / ring.flange_width,
        area,
        inertia,
        hoop.at_ring,
        section,
    )
