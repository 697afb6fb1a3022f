//! The program against exact answers, itself on other ranks, and the balance of energy.

#[path = "../common/mod.rs"]
#[allow(dead_code)] // this program uses a part of it
mod common;
mod accuracy;
mod any_flow;
mod any_interface;
mod any_mesh;
mod beams;
mod blocks;
mod branches;
mod cracks;
mod cubes;
mod curved;
mod curved_crossing;
mod diffusion;
mod energy;
mod equilibrium;
mod film;
mod first_correction;
mod flow;
mod flow_orders;
mod fluid;
mod friction;
mod friction_flow;
#[path = "../common/faults.rs"]
#[allow(dead_code)] // as above
mod faults;
mod gallery;
mod gaps;
mod grid;
mod held_sides;
mod inclusions;
mod initial_stress;

mod kills;
mod known_pressure;
mod locking;
mod lorentz;
mod mandel;
mod manufactured;
mod orders;
mod patches;
mod path;
mod platen;
mod presets;
mod ranks;
mod reactions;
mod reference;
mod reduction;
mod refined_mesh;
mod refinement;
mod repeat;
mod restart;
mod restart_cases;
mod restart_mesh;
mod scene;
#[path = "../common/served.rs"]
mod served;
mod shipped;
mod short_joints;
mod signals;
mod small_meshes;
mod stability;
mod stages;
mod steps;
mod suite;
mod units;
