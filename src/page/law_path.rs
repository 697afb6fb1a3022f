//! What a law says along the path that an interface took.

use crate::law::{InterfaceLaw, Local, Past};

/// The means over an interface at one instant, in the frame (n, t1, t2).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Mean {
    /// m
    pub jump: Local,
    /// Pa
    pub traction: Local,
    pub damage: f64,
}

/// Jumps (m) and tractions (Pa) of one component.
pub(super) type Curve = Vec<(f64, f64)>;

/// A law between bodies.
#[derive(Clone, Copy)]
pub(super) struct Joint<'a> {
    pub law: &'a dyn InterfaceLaw,
    /// Of the bodies, E over a length (Pa/m).
    pub stiffness: f64,
    /// 2 or 3.
    pub dim: usize,
}

/// How far one component is loaded.
pub(super) struct Range {
    /// The least traction (Pa), not positive.
    pub low: f64,
    /// The largest traction (Pa), or that at the jump `reach` (m) if it is larger.
    pub high: f64,
    pub reach: f64,
}

/// Samples of the whole path, and the fewest between two instants.
const SAMPLES: usize = 4000;
const FEWEST: usize = 4;

/// The law's answer where the augmented traction t + r w goes in straight lines from mean to mean,
/// for each component. An interface that opens evenly lies on it at every instant.
pub(super) fn along(joint: Joint<'_>, means: &[Mean]) -> [Curve; 3] {
    let Joint { law, stiffness, dim } = joint;
    let r = law.augmentation(stiffness);
    let steps = (SAMPLES / means.len().max(1)).max(FEWEST);
    let mut curves: [Curve; 3] = std::array::from_fn(|_| vec![(0.0, 0.0)]);
    let (friction, mut sliding) = (law.friction(), [0.0; 2]);
    let (mut history, mut from) = (0.0, [0.0; 3]);
    for mean in means {
        let to: Local = std::array::from_fn(|c| mean.traction[c] + r * mean.jump[c]);
        // In one step, as far as is known: what some laws answer depends on it.
        let before = history;
        for step in 1..=steps {
            let share = step as f64 / steps as f64;
            // The last one to the last bit.
            let p = std::array::from_fn(|c| (1.0 - share) * from[c] + share * to[c]);
            let past = |history: f64| Past { history, sliding };
            let mut answer = friction.respond(law, p, r, past(before), dim);
            if step == steps {
                let further = history_of(law, answer.history, mean.damage);
                if further > answer.history {
                    answer = friction.respond(law, p, r, past(further), dim);
                }
                sliding = [answer.jump[1], answer.jump[2]];
            }
            history = answer.history;
            for (c, curve) in curves.iter_mut().enumerate() {
                curve.push((answer.jump[c], answer.traction[c]));
            }
        }
        from = to;
    }
    curves
}

/// The history at which the law has the damage, where that is more than at `history`: between two
/// instants an interface may have been opened further than at either.
fn history_of(law: &dyn InterfaceLaw, history: f64, damage: f64) -> f64 {
    let Some(end) = law.jump_scale().filter(|_| damage > law.damage(history) + 1e-6) else {
        return history;
    };
    let (mut low, mut high) = (history, end);
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        if law.damage(middle) < damage { low = middle } else { high = middle }
    }
    high
}

/// The law where one component alone is loaded for the first time. The normal component is in
/// contact below zero; a tangential one is the same both ways, and taken so where the least
/// traction is negative.
pub(super) fn first_loading(joint: Joint<'_>, component: usize, range: Range) -> Curve {
    let Joint { law, stiffness, dim } = joint;
    let Range { low, high, reach } = range;
    let r = law.augmentation(stiffness);
    let most = high.max(r * reach);
    let mut loads: Vec<f64> = (0..=SAMPLES).map(|i| most * i as f64 / SAMPLES as f64).collect();
    // The corner itself.
    loads.extend(law.strength().filter(|strength| *strength < most));
    loads.sort_by(f64::total_cmp);
    let mut history = 0.0;
    let mut curve: Curve = Vec::with_capacity(2 * loads.len());
    for load in loads {
        let mut p = [0.0; 3];
        p[component] = load;
        let answer = law.respond(p, r, history, dim);
        history = answer.history;
        curve.push((answer.jump[component], answer.traction[component]));
    }
    if component > 0 && low < 0.0 {
        let back: Curve = curve.iter().rev().map(|(w, t)| (-w, -t)).collect();
        return back.into_iter().chain(curve).collect();
    }
    if component == 0 && low < 0.0 {
        curve.insert(0, (0.0, low));
    }
    curve
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::law::LinearSoftening;

    const LAW: LinearSoftening = LinearSoftening {
        strength: 1.1e6,
        fracture_energy: 900.0,
        augmentation: 10.0,
        friction: 0.0,
    };

    const JOINT: Joint<'_> = Joint { law: &LAW, stiffness: 1e9, dim: 3 };

    fn critical_jump() -> f64 {
        2.0 * LAW.fracture_energy / LAW.strength
    }

    fn mean(jump: f64, damage: f64) -> Mean {
        let critical = critical_jump();
        let largest = (damage * critical).max(jump);
        let traction = LAW.strength * (1.0 - largest / critical) * jump / largest;
        Mean { jump: [jump, 0.0, 0.0], traction: [traction, 0.0, 0.0], damage }
    }

    #[test]
    fn a_path_goes_through_what_the_law_says_also_after_unloading() {
        let critical = critical_jump();
        // The last was opened further on the way than it is.
        let means =
            [mean(2e-4, 2e-4 / critical), mean(1e-4, 2e-4 / critical), mean(5e-4, 9e-4 / critical)];
        let curve = &along(JOINT, &means)[0];
        for mean in means {
            let at = (mean.jump[0], mean.traction[0]);
            let near = |p: &&(f64, f64)| {
                (p.0 - at.0).abs() < 1e-9 * critical && (p.1 - at.1).abs() < 1e-6 * LAW.strength
            };
            assert!(curve.iter().any(|p| near(&p)), "{at:?}");
        }
    }

    #[test]
    fn first_loading_has_the_corner_and_the_end() {
        let reach = 1.1 * critical_jump();
        let curve = first_loading(JOINT, 0, Range { low: -1e5, high: 0.0, reach });
        assert_eq!(curve[0], (0.0, -1e5));
        assert!(curve.contains(&(0.0, 1.1e6)));
        let last = curve[curve.len() - 1];
        assert!((last.0 - reach).abs() < 1e-12 && last.1.abs() < 1e-6, "{last:?}");
        let both = first_loading(JOINT, 1, Range { low: -1.0, high: 1.0, reach });
        assert!((both[0].0 + reach).abs() < 1e-12);
    }
}
