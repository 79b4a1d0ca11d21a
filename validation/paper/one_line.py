"""A run in one line: what its summary says, as columns of a table."""

NAMES = {"P": "bottom_N_per_m", "T": "shear_N_per_m", "N": "normal_N_per_m"}


def one_line(summary: dict) -> dict:
    """Columns of a run's summary.json; None where the run did not get so far.

    Forces in N/m, lengths in m; `sheared_count` and the next are of the shear zones inside.
    """
    row = {}
    for state in ("filling", "residual"):
        forces = summary.get(state, {})
        row |= {f"{state}_{letter}": forces.get(name) for letter, name in NAMES.items()}
    pattern, stay = summary.get("flow_pattern", {}), summary.get("residence", {})
    row |= {
        "flow_pattern": pattern.get("kind"),
        "transition_left_m": pattern.get("transition_left_m"),
        "transition_right_m": pattern.get("transition_right_m"),
        "stagnant_share": pattern.get("stagnant_area_share"),
        "never_leaves_share": stay.get("never_share"),
        "surface_leaves_after_plug_times": stay.get("first_from_surface_over_plug"),
    }
    over = summary.get("largest_overpressure", {})
    row |= {
        "overpressure_factor": over.get("factor"),
        "overpressure_wall": over.get("wall"),
        "overpressure_height_m": over.get("height_m"),
        "overpressure_displacement_m": over.get("displacement_m"),
    }
    stresses = summary.get("largest_wall_normal_stress_Pa", {})
    row["largest_wall_stress_Pa"] = max((state["pressure_cell"] for state in stresses.values()), default=None)
    walls, inside = summary.get("shear_zones", {}), summary.get("zones_inside", {})
    row |= {f"zone_{side}_m": walls.get(side, {}).get("thickness_m") for side in ("left", "right")}
    first = (inside.get("zones") or [{}])[0]
    row |= {
        "zones_count": inside.get("count"),
        "zones_branching_points": inside.get("branching_points"),
        "zones_on_walls": inside.get("branching_points_on_walls"),
        "longest_zone_thickness_m": first.get("thickness_m"),
        "longest_zone_over_d50": first.get("thickness_over_d50"),
        "longest_zone_over_l_c": first.get("thickness_over_characteristic_length"),
        "longest_zone_curvature_1_per_m": first.get("curvature_1_per_m"),
    }
    theory = summary.get("theory", {})
    row |= {
        "discharged_kg_per_m": summary.get("ledger", {}).get("discharged_kg_per_m"),
        "outlet_eccentricity_m": theory.get("outlet_eccentricity_m"),
        "eurocode_discharge_Pa": theory.get("eurocode", {}).get("discharge_normal_Pa"),
        "beverloo_kg_per_s_m": theory.get("beverloo_kg_per_s_m"),
    }
    return row
