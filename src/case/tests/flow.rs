//! What of flow is computed, left out and refused.

use super::mistakes::message;
use super::*;

const POROUS: &str = "materials.rock.porous={biot: 0.8, porosity: 0.15, permeability: 1.0e-19, \
                      viscosity: 1.0e-3, fluid_compressibility: 5.0e-10, fluid_density: 1000, \
                      density: 2500}";

#[test]
fn flow_is_computed_where_a_pressure_is_not_known_beforehand() {
    let case = good(&[POROUS, "boundary.2={on: top, pressure: 3}"]);
    assert_eq!(case.physics, PhysicsDecision::HydroMechanics);
    let flow = case.flow.as_ref().expect("flow");
    assert_eq!((flow.theta, flow.tolerance, flow.lumped), (1.0, None, false));
    assert!(flow.initial.is_zero());
    let columns = case.columns();
    let last = ["energy.external", "energy.fluid", "mass.in", "mass.out", "mass.stored"];
    assert_eq!(columns[columns.len() - 5..], last);

    assert!(!flow.equilibrium);
    assert_eq!(case.load_times(), case.time);
    let balanced = good(&[POROUS, "initial.equilibrium=true"]);
    assert!(balanced.flow.as_ref().expect("flow").equilibrium);
    // Loads and prescribed displacements have to be sound there too.
    assert_eq!(balanced.load_times()[..2], [balanced.start, balanced.time[0]]);

    let known = [POROUS, "boundary.2={on: all, pressure: 0}"];
    assert_eq!(good(&known).physics, PhysicsDecision::Mechanics);
    let asked = good(&[known[0], known[1], "physics=hydro_mechanics", "time.theta=0.5"]);
    assert_eq!(asked.physics, PhysicsDecision::HydroMechanics);
    assert_eq!(asked.flow.expect("flow").theta, 0.5);
    let resolved = good(&[POROUS]).resolved();
    assert_eq!(resolved["physics"], "hydro_mechanics");
}

#[test]
fn a_pressure_that_is_known_is_a_load() {
    let known = [POROUS, "boundary.2={on: all, pressure: {table: [[0, 1], [2, 3]]}}"];
    for more in ["physics=auto", "physics=mechanics"] {
        let case = good(&[known[0], known[1], more]);
        assert_eq!(case.physics, PhysicsDecision::Mechanics);
        assert!(case.pressure_is_load && case.flow.is_none());
        let why = "the pressure is prescribed on all nodes, so it acts as a load";
        assert!(case.left_out[0].contains(why), "{:?}", case.left_out);
        assert_eq!(case.columns().last().map(String::as_str), Some("energy.fluid"));
        let again = Case::read(&case.resolved().to_string(), Path::new("elsewhere.yaml"), &[]);
        assert!(again.expect("the resolved case").pressure_is_load);
    }
    for more in [
        "time.tolerance=0.1",
        "boundary.3={on: left, flux: 1}",
        "interfaces.0.fluid={pressure: 1, connected: true}",
        "expect=[{quantity: mass.in, at: 1, equals: 0, absolute: 1}]",
        "physics=hydro_mechanics",
    ] {
        let case = good(&[known[0], known[1], more]);
        assert!(case.flow.is_some() && !case.pressure_is_load, "{more}");
    }
    let none = good(&[POROUS, "boundary.2={on: all, pressure: 0}"]);
    assert!(!none.pressure_is_load);
    let reference = "materials.rock.porous.reference_pressure=1";
    assert!(good(&[POROUS, "boundary.2={on: all, pressure: 0}", reference]).pressure_is_load);
}

#[test]
fn a_connected_fluid_reports_what_flows_into_either_side() {
    let case = good(&[POROUS, "interfaces.0.fluid={pressure: 1.0e7, connected: true}"]);
    assert!(case.interfaces[0].connected);
    let columns = case.columns();
    for name in ["joint.flux_lower", "joint.flux_upper"] {
        assert!(columns.contains(&name.to_owned()), "{name}");
    }
}

#[test]
fn fluid_flows_along_an_interface() {
    for fluid in ["{flow: true}", "{injection: {table: [[1, 0], [1.5, 1.0e-3]]}}"] {
        let case = good(&[POROUS, &format!("interfaces.0.fluid={fluid}")]);
        assert_eq!(case.physics, PhysicsDecision::HydroMechanics);
        assert!(case.interfaces[0].film.is_some());
        let columns = case.columns();
        for name in ["joint.pressure.min", "joint.pressure.mean", "joint.flux_upper"] {
            assert!(columns.contains(&name.to_owned()), "{name}");
        }
        assert_eq!(case.breakpoints().contains(&1.5), fluid.contains("table"));
    }
}

#[test]
fn mistakes_of_flow_are_told() {
    for (assignments, words) in [
        (vec!["boundary.2={on: top, pressure: 3}"], "acts on pores, but no material is porous"),
        (vec!["boundary.2={on: top, flux: 1}"], "acts on pores, but no material is porous"),
        (vec!["initial.pressure=1"], "acts on pores, but no material is porous"),
        (
            vec!["interfaces.0.fluid={pressure: 1.0e7, connected: true}"],
            "acts on pores, but no material is porous",
        ),
        (vec!["initial.equilibrium=true"], "needs a pore pressure that is computed"),
        (
            vec![POROUS, "physics=mechanics", "initial.equilibrium=true"],
            "needs a pore pressure that is computed",
        ),
        (vec!["physics=hydro_mechanics"], "hydro_mechanics needs a material with porous data"),
        (
            vec!["gravity=[0, 0, -9.81]"],
            "materials.rock.elastic.density is missing: gravity acts on it",
        ),
        (
            vec![POROUS, "physics=mechanics", "boundary.2={on: top, pressure: 3}"],
            "needs physics: hydro_mechanics or auto",
        ),
        (vec![POROUS, "time.theta=0.4"], "must lie in [0.5, 1], got 0.4"),
        (
            vec![POROUS, "boundary.2={on: top, pressure: 3, flux: 1}"],
            "prescribes the pressure and the flux; give one of them",
        ),
        (vec![POROUS, "boundary.2={on: all, flux: 1}"], "is on `all`, which is no surface"),
        (vec![POROUS, "materials.rock.porous.porosity=1.5"], "porosity must be"),
        (vec![POROUS, "materials.rock.porous.biot=0.1"], "must be at least the porosity 0.15"),
        (vec![POROUS, "materials.rock.porous.biot=1.1"], "biot must be"),
        (vec![POROUS, "materials.rock.porous.permeability=-1"], "permeability must be"),
        (vec![POROUS, "interfaces.0.fluid={}"], "needs pressure, flow: true or injection"),
        (
            vec![POROUS, "interfaces.0.fluid={pressure: 1, injection: 1}"],
            "cannot stand beside flow and injection",
        ),
        (
            vec![POROUS, "interfaces.0.fluid={flow: true, connected: true}"],
            "cannot stand beside flow and injection",
        ),
        (vec!["interfaces.0.fluid={flow: true}"], "rock has no porous data"),
        (
            vec![POROUS, "interfaces.0.fluid={flow: true}", "physics=mechanics"],
            "needs physics: hydro_mechanics or auto",
        ),
        (vec![POROUS, "solver.form=saddle_point"], "saddle_point knows no pore pressure"),
        (vec![POROUS, "solver.stability=follow"], "must be auto or off with flow"),
        (
            vec![POROUS, "control={opening: {of: joint, equals: 1.0e-4}}"],
            "cannot stand beside flow, which depends on time",
        ),
        (
            vec![
                POROUS,
                "boundary.2={on: all, pressure: 3}",
                "control={opening: {of: joint, equals: 1.0e-4}}",
            ],
            "control does not scale the pore pressure (boundary.2.pressure)",
        ),
    ] {
        let text = message("mesh", "mesh", &assignments);
        assert!(text.contains(words), "{assignments:?}: {text}");
    }
    let two = [
        "materials.rock.z=[0, 2]",
        "materials.base={z: [2, 5], elastic: {young_modulus: 1.0e9, poisson_ratio: 0.2}}",
        POROUS,
        "boundary.2={on: top, pressure: 3}",
    ];
    let text = message("mesh", "mesh", &two);
    assert!(text.contains("acts on base, which has no porous data"), "{text}");
    // The interface at 2.5 m lies in the rock, that at 2 m between the two.
    let base = "materials.base.porous={biot: 0.8, porosity: 0.15, permeability: 1.0e-19, \
                viscosity: 1.0e-2, fluid_compressibility: 5.0e-10, fluid_density: 1000, \
                density: 2500}";
    let film = "interfaces.0.fluid={flow: true}";
    good(&[two[0], two[1], POROUS, base, film]);
    let text = message("mesh", "mesh", &[two[0], two[1], POROUS, base, film, "interfaces.0.z=2"]);
    assert!(text.contains("viscosity is 0.01, but 0.001 in rock: one fluid"), "{text}");
}
