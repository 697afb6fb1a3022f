//! What the coupling must reproduce on meshes that do not match.

use std::collections::BTreeMap;

use super::*;
use crate::element::Shape;
use crate::error::Error;

/// Random cuts of [0, 1] into `n` intervals, the ends exact.
fn cuts(n: usize, seed: u64) -> Vec<f64> {
    let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
    (0..=n)
        .map(|i| {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            let shake = 0.6 * ((state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5);
            let inside = if i == 0 || i == n { 0.0 } else { shake };
            (i as f64 + inside) / n as f64
        })
        .collect()
}

/// The rectangle [0, 2] x [0, 1] cut into `n` facets with random lines; odd seeds run clockwise.
pub fn grid(n: [usize; 2], seed: u64, first: u64) -> Vec<PlaneFacet> {
    let (x, y) = (cuts(n[0], seed), cuts(n[1], seed + 100));
    let mut out = Vec::new();
    for j in 0..n[1] {
        for i in 0..n[0] {
            let mut corners = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)];
            if seed % 2 == 1 {
                corners.reverse();
            }
            out.push(PlaneFacet::quad(
                corners.map(|(i, j)| first + (j * (n[0] + 1) + i) as u64),
                corners.map(|(i, j)| [2.0 * x[i], y[j]]),
            ));
        }
    }
    out
}

/// The interval [0, 1] cut into `n` segments.
pub fn lines(n: usize, seed: u64, first: u64) -> Vec<PlaneFacet> {
    let x = cuts(n, seed);
    (0..n)
        .map(|i| PlaneFacet::line([first + i as u64, first + i as u64 + 1], [x[i], x[i + 1]]))
        .collect()
}

/// The same facets with nodes of second order: those at one place have one number.
pub fn second_order(facets: Vec<PlaneFacet>, first: u64) -> Vec<PlaneFacet> {
    let mut numbers: BTreeMap<[u64; 2], u64> = BTreeMap::new();
    facets
        .iter()
        .map(|facet| {
            let shape = Shape::of(facet.shape().dim(), 2);
            let plain = PlaneFacet::new(shape, &vec![0; shape.nodes()], facet.corners());
            let number = |x: &[f64; 2]| {
                let next = first + numbers.len() as u64;
                *numbers.entry(x.map(|x| (x * 1e9).round() as u64)).or_insert(next)
            };
            let nodes: Vec<u64> = plain.positions().iter().map(number).collect();
            PlaneFacet::new(shape, &nodes, facet.corners())
        })
        .collect()
}

fn rows(
    secondary: &[PlaneFacet],
    primary: &[PlaneFacet],
    dropped: impl Fn([f64; 2]) -> bool,
) -> Vec<Contribution> {
    let pairs = candidates(secondary, primary);
    let mut out = Vec::new();
    for (s, facet) in secondary.iter().enumerate() {
        let near: Vec<&PlaneFacet> =
            pairs.iter().filter(|pair| pair.0 == s).map(|pair| &primary[pair.1]).collect();
        let mut mask = 0;
        for (b, &x) in facet.positions().iter().enumerate() {
            mask |= u16::from(dropped(x)) << b;
        }
        out.extend(facet_rows(facet, &near, &[mask, mask]).unwrap());
    }
    out
}

fn places(facets: &[PlaneFacet]) -> BTreeMap<u64, [f64; 2]> {
    facets.iter().flat_map(|f| f.nodes().iter().copied().zip(f.positions().to_vec())).collect()
}

type Row = (f64, BTreeMap<u64, f64>, BTreeMap<u64, f64>);

fn assemble(contributions: &[Contribution]) -> BTreeMap<u64, Row> {
    let mut out: BTreeMap<u64, Row> = BTreeMap::new();
    for c in contributions {
        assert_eq!(c.components, [true, true, false]);
        let row = out.entry(c.node).or_default();
        row.0 += c.weight;
        c.secondary.iter().for_each(|(k, v)| *row.1.entry(*k).or_default() += v);
        c.primary.iter().for_each(|(l, v)| *row.2.entry(*l).or_default() += v);
    }
    out
}

/// Constants and linears make no jump, and a uniform traction gives consistent nodal forces.
fn check(secondary: &[PlaneFacet], primary: &[PlaneFacet], dropped: impl Fn([f64; 2]) -> bool) {
    let rows = assemble(&rows(secondary, primary, dropped));
    let place: BTreeMap<u64, [f64; 2]> =
        places(secondary).into_iter().chain(places(primary)).collect();
    for field in [|_: [f64; 2]| 1.0, |x: [f64; 2]| x[0] - 0.3, |x: [f64; 2]| 2.0 * x[1] - x[0]] {
        for (node, (_, here, there)) in &rows {
            let value = |side: &BTreeMap<u64, f64>| {
                side.iter().map(|(k, c)| c * field(place[k])).sum::<f64>() / here[node]
            };
            assert!((value(here) - value(there)).abs() < 1e-14 * 4.0, "node {node}");
        }
    }
    let area: f64 = secondary.iter().map(PlaneFacet::area).sum();
    let weights: f64 = rows.values().map(|row| row.0).sum();
    assert!((weights - area).abs() < 1e-13 * area);
    for (side, facets) in [(0, secondary), (1, primary)] {
        let mut forces: BTreeMap<u64, f64> = BTreeMap::new();
        for row in rows.values() {
            let coefficients = if side == 0 { &row.1 } else { &row.2 };
            coefficients.iter().for_each(|(k, c)| *forces.entry(*k).or_default() += c);
        }
        for facet in facets {
            let consistent = |k: usize| -> f64 {
                let mut values = [0.0; MOST_NODES];
                let value = |p: &crate::element::QuadraturePoint| {
                    facet.shape().values(p.xi, &mut values);
                    p.weight * values[k]
                };
                facet.points().iter().map(value).sum()
            };
            for (k, node) in facet.nodes().iter().enumerate() {
                *forces.entry(*node).or_default() -= consistent(k);
            }
        }
        assert!(forces.values().all(|f| f.abs() < 1e-14 * area));
    }
}

const RATIOS: [(usize, usize); 6] = [(2, 3), (3, 2), (1, 4), (4, 1), (11, 12), (12, 11)];

#[test]
fn linear_fields_and_uniform_tractions_pass_any_pair_of_grids() {
    for (seed, (a, b)) in RATIOS.into_iter().enumerate() {
        let seed = seed as u64;
        check(&grid([a, a], seed, 0), &grid([b, b], seed + 7, 1000), |_| false);
        check(&lines(a, seed, 0), &lines(b, seed + 7, 1000), |_| false);
    }
}

/// Of second order on either side or on both.
#[test]
fn they_pass_with_facets_of_second_order() {
    type Make = fn(Vec<PlaneFacet>, u64) -> Vec<PlaneFacet>;
    let (plain, curved): (Make, Make) = (|facets, _| facets, second_order);
    for (one, other) in [(curved, plain), (plain, curved), (curved, curved)] {
        for (seed, (a, b)) in RATIOS.into_iter().enumerate() {
            let seed = seed as u64;
            let secondary = one(grid([a + 1, a + 1], seed, 0), 0);
            let primary = other(grid([b, b], seed + 7, 1000), 1000);
            check(&secondary, &primary, |_| false);
            check(&secondary, &primary, |x| x[0] == 0.0 || x[1] == 1.0);
            let (secondary, primary) =
                (one(lines(a + 1, seed, 0), 0), other(lines(b, seed + 7, 1000), 1000));
            check(&secondary, &primary, |_| false);
            check(&secondary, &primary, |x| x[0] == 0.0);
        }
    }
}

/// A traction that varies linearly is carried without a loss, and quadratic fields make no jump.
#[test]
fn second_order_reproduces_quadratic_fields_and_linear_tractions() {
    for (seed, (a, b)) in RATIOS.into_iter().enumerate() {
        let seed = seed as u64;
        let secondary = second_order(grid([a, a], seed, 0), 0);
        let primary = second_order(grid([b, b], seed + 7, 1000), 1000);
        let place: BTreeMap<u64, [f64; 2]> =
            places(&secondary).into_iter().chain(places(&primary)).collect();
        let rows = assemble(&rows(&secondary, &primary, |_| false));
        let field = |x: [f64; 2]| x[0] * x[0] - 3.0 * x[0] * x[1] + 0.5 * x[1] * x[1];
        for (node, (_, here, there)) in &rows {
            let sum = |side: &BTreeMap<u64, f64>| -> f64 {
                side.iter().map(|(k, c)| c * field(place[k])).sum::<f64>() / here[node]
            };
            assert!((sum(here) - sum(there)).abs() < 1e-13, "node {node}");
        }
        let traction = |x: [f64; 2]| 1.0 + x[0] - 2.0 * x[1];
        let mut forces: BTreeMap<u64, f64> = BTreeMap::new();
        for (node, row) in &rows {
            for (k, c) in &row.2 {
                *forces.entry(*k).or_default() += c * traction(place[node]);
            }
        }
        let mut values = [0.0; MOST_NODES];
        for facet in &primary {
            for p in facet.points() {
                facet.shape().values(p.xi, &mut values);
                let nodes = facet.nodes().iter().zip(values);
                let x: [f64; 2] = nodes
                    .clone()
                    .fold([0.0; 2], |x, (k, n)| [x[0] + n * place[k][0], x[1] + n * place[k][1]]);
                nodes.for_each(|(k, n)| {
                    *forces.entry(*k).or_default() -= p.weight * n * traction(x)
                });
            }
        }
        assert!(forces.values().all(|f| f.abs() < 1e-13), "{a}:{b} {forces:?}");
    }
}

#[test]
fn they_pass_with_multipliers_dropped_on_the_edges() {
    for (seed, (a, b)) in RATIOS.into_iter().enumerate() {
        let seed = seed as u64;
        let (secondary, primary) = (grid([a + 1, a + 1], seed, 0), grid([b, b], seed + 7, 1000));
        check(&secondary, &primary, |x| x[0] == 0.0);
        check(&secondary, &primary, |x| x[0] == 0.0 || x[1] == 1.0);
        check(&secondary, &primary, |x| x == [2.0, 0.0]);
        if a > 2 {
            let border = |x: [f64; 2]| x[0] == 0.0 || x[0] == 2.0 || x[1] == 0.0 || x[1] == 1.0;
            check(&secondary, &primary, border);
        }
        check(&lines(a + 1, seed, 0), &lines(b, seed + 7, 1000), |x| x[0] == 0.0);
    }
}

#[test]
fn linear_fields_pass_distorted_facets() {
    let bend = |facets: Vec<PlaneFacet>, amount: f64| -> Vec<PlaneFacet> {
        let bent = |x: [f64; 2]| {
            let bump = x[0] * (2.0 - x[0]) * x[1] * (1.0 - x[1]);
            [x[0] + amount * bump, x[1] - amount * bump]
        };
        facets
            .iter()
            .map(|f| {
                let nodes = std::array::from_fn(|a| f.nodes()[a]);
                PlaneFacet::quad(nodes, std::array::from_fn(|a| bent(f.positions()[a])))
            })
            .collect()
    };
    let (secondary, primary) = (bend(grid([4, 3], 2, 0), 0.4), bend(grid([5, 5], 9, 1000), -0.3));
    let rows = assemble(&rows(&secondary, &primary, |x| x[0] == 0.0));
    let place: BTreeMap<_, _> = places(&secondary).into_iter().chain(places(&primary)).collect();
    for (node, (_, here, there)) in &rows {
        let value = |side: &BTreeMap<u64, f64>| {
            side.iter().map(|(k, c)| c * (place[k][0] - 3.0 * place[k][1])).sum::<f64>()
        };
        assert!((value(here) - value(there)).abs() < 1e-13 * here[node]);
    }
}

#[test]
fn matching_facets_give_a_permutation_to_the_last_bit() {
    let (secondary, turned) = (grid([7, 5], 4, 0), |f: &PlaneFacet| {
        let order = [2, 1, 0, 3];
        PlaneFacet::quad(
            order.map(|a| f.nodes()[a] + 1000),
            order.map(|a| f.positions()[a].map(|x| x + 1e-12)),
        )
    });
    let primary: Vec<PlaneFacet> = secondary.iter().map(turned).collect();
    for edge in [-1.0, 0.0] {
        for row in rows(&secondary, &primary, |x| x[0] == edge) {
            let mut moved: Vec<(u64, f64)> =
                row.secondary.iter().map(|&(k, c)| (k + 1000, c)).collect();
            moved.sort_unstable_by_key(|&(node, _)| node);
            assert_eq!(moved, row.primary);
            assert_eq!(row.secondary[0].0, row.node);
        }
    }
}

#[test]
fn components_with_their_own_masks_get_their_own_rows() {
    let facet = PlaneFacet::quad([4, 5, 6, 7], [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]);
    let primary = PlaneFacet::quad([0, 1, 2, 3], [[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]]);
    let rows = facet_rows(&facet, &[&primary], &[0b1001, 0, 0b1001]).unwrap();
    let nodes = |components: [bool; 3]| -> Vec<u64> {
        rows.iter().filter(|r| r.components == components).map(|r| r.node).collect()
    };
    assert_eq!(nodes([true, false, true]), [5, 6]);
    assert_eq!(nodes([false, true, false]), [4, 5, 6, 7]);
    assert!(rows.iter().all(|r| !r.components[1] || r.secondary.len() == 1));
    assert_eq!(rows.len(), 6);
    assert!(facet_rows(&facet, &[&primary], &[0b1111; 3]).unwrap().is_empty());
}

#[test]
fn a_side_that_does_not_cover_is_an_error_with_place_and_fraction() {
    let facet = PlaneFacet::quad([0, 1, 2, 3], [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]);
    let part = PlaneFacet::quad([4, 5, 6, 7], [[0.0, 0.0], [0.75, 0.0], [0.75, 1.0], [0.0, 1.0]]);
    let Err(Error::Input(message)) = facet_rows(&facet, &[&part], &[0; 3]) else {
        panic!("accepted");
    };
    assert!(message.contains("does not cover the secondary facet at (0.500000, 0.500000) m"));
    assert!(message.contains("75.000000 %"), "{message}");
    let big = PlaneFacet::quad([4, 5, 6, 7], [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [0.0, 1.0]]);
    let Err(Error::Input(message)) = facet_rows(&facet, &[&big, &part], &[0; 3]) else {
        panic!("accepted");
    };
    assert!(message.contains("overlaps itself"), "{message}");
    let flat = PlaneFacet::line([0, 1], [0.5, 0.5]);
    assert!(matches!(facet_rows(&flat, &[], &[0; 2]), Err(Error::Input(_))));
    assert_eq!(flat.shape(), Shape::Line2);
}
