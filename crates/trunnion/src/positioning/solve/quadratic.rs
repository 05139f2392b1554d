//! Strictly convex quadratic programs of four unknowns, by the dual method.

use nalgebra::{Matrix4, Vector4};

/// `normal . x >= bound`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct LinearConstraint {
    pub(crate) normal: Vector4<f64>,
    pub(crate) bound: f64,
}

/// Minimum of `x' G x / 2 - g' x` and the multiplier of each constraint.
#[derive(Debug, Clone)]
pub(crate) struct QuadraticSolution {
    pub(crate) x: Vector4<f64>,
    pub(crate) multipliers: Vec<f64>,
}

/// Constraint that holds with equality at the present point.
#[derive(Debug, Clone, Copy)]
struct BindingConstraint {
    /// Index among all constraints.
    index: usize,
    multiplier: f64,
}

/// A breach below this share of the size of the numbers in it is rounding (four products and sums,
/// amplified by the condition of at most four active normals).
const ROUNDING: f64 = 1e-11;

/// Solves the program; `None` where the constraints contradict each other.
///
/// Goldfarb and Idnani, *A numerically stable dual method for solving strictly convex quadratic
/// programs*, Mathematical Programming 27 (1983): starts at the free minimum and adds the most
/// violated constraint until none is left.
pub(crate) fn minimise(
    inverse: &Matrix4<f64>,
    g: &Vector4<f64>,
    constraints: &[LinearConstraint],
) -> Option<QuadraticSolution> {
    let mut x = inverse * g;
    let mut active: Vec<BindingConstraint> = Vec::with_capacity(4);
    // Each outer step raises the dual objective; cycles are impossible but for rounding.
    let rounds = 10 * (constraints.len() + 4);
    for _ in 0..rounds {
        let Some((entering, mut slack)) = most_violated(constraints, &x, &active) else {
            let mut multipliers = vec![0.0; constraints.len()];
            for BindingConstraint { index, multiplier } in active {
                *multipliers.get_mut(index)? = multiplier;
            }
            return Some(QuadraticSolution { x, multipliers });
        };
        let normal = constraints.get(entering)?.normal;
        let mut multiplier = 0.0;
        loop {
            let (z, r) = directions(inverse, &normal, &active, constraints)?;
            // Rate at which the step raises the constraint; 0 if its normal depends on the active
            // ones.
            let descent = z.dot(&normal);
            let independent = descent > ROUNDING * normal.dot(&(inverse * normal));
            // Step at which the entering constraint is met, and step at which a multiplier reaches
            // 0.
            let full = if independent { -slack / descent } else { f64::INFINITY };
            let (leaving, partial) = shortest(&active, &r);
            let step = full.min(partial);
            // Neither ends the step: the dual is unbounded, the constraints contradict each other.
            if !step.is_finite() {
                return None;
            }
            for (entry, rate) in active.iter_mut().zip(r.iter()) {
                entry.multiplier = (entry.multiplier - step * rate).max(0.0);
            }
            multiplier += step;
            if independent {
                x += z * step;
                slack += step * descent;
            }
            // A full step: the constraint becomes active. A partial one drops the blocking
            // constraint.
            if full <= partial {
                active.push(BindingConstraint { index: entering, multiplier });
                break;
            }
            active.remove(leaving);
        }
    }
    None
}

fn most_violated(
    constraints: &[LinearConstraint],
    x: &Vector4<f64>,
    active: &[BindingConstraint],
) -> Option<(usize, f64)> {
    let mut worst = None;
    let mut depth = 0.0;
    for (index, constraint) in constraints.iter().enumerate() {
        if active.iter().any(|held| held.index == index) {
            continue;
        }
        let norm = constraint.normal.norm();
        if norm <= 0.0 {
            continue;
        }
        let slack = constraint.normal.dot(x) - constraint.bound;
        let rounding = ROUNDING * (norm * x.norm() + constraint.bound.abs());
        let relative = slack / norm;
        if slack < -rounding && relative < depth {
            depth = relative;
            worst = Some((index, slack));
        }
    }
    worst
}

/// Returns the step of `x` along the constraint to be added, kept inside the active ones, and the rates at
/// which their multipliers fall.
fn directions(
    inverse: &Matrix4<f64>,
    normal: &Vector4<f64>,
    active: &[BindingConstraint],
    constraints: &[LinearConstraint],
) -> Option<(Vector4<f64>, Vector4<f64>)> {
    let mut normals = [Vector4::zeros(); 4];
    for (slot, held) in normals.iter_mut().zip(active) {
        *slot = constraints.get(held.index)?.normal;
    }
    let count = active.len().min(4);
    let mut gram = [[0.0; 4]; 4];
    let mut right = [0.0; 4];
    // With N the active normals and H = G^-1: r = (N' H N)^-1 N' H n, z = H n - H N r.
    let entering = inverse * normal;
    let mut raised = [Vector4::zeros(); 4];
    for row in 0..count {
        raised[row] = inverse * normals[row];
        for column in 0..=row {
            gram[row][column] = normals[row].dot(&raised[column]);
        }
        right[row] = normals[row].dot(&entering);
    }
    let r = positive(gram, right, count)?;
    let z = (0..count).fold(entering, |z, row| z - raised[row] * r[row]);
    Some((z, Vector4::from(r)))
}

/// Solves `a r = b` of the order `count`, `a` symmetric and positive, by `L D L'` in its lower triangle;
/// `None` where rounding has left it singular.
fn positive(mut a: [[f64; 4]; 4], mut b: [f64; 4], count: usize) -> Option<[f64; 4]> {
    for k in 0..count {
        let pivot = a[k][k];
        if pivot <= 0.0 {
            return None;
        }
        for row in k + 1..count {
            let share = a[row][k] / pivot;
            let lead = a.map(|line| line[k]);
            for (entry, x) in a[row].iter_mut().zip(lead).take(row + 1).skip(k + 1) {
                *entry -= share * x;
            }
            b[row] -= share * b[k];
        }
    }
    for k in (0..count).rev() {
        b[k] /= a[k][k];
        for row in 0..k {
            b[row] -= a[k][row] * b[k];
        }
    }
    Some(b)
}

/// Returns the active constraint whose multiplier reaches zero first, and after which step.
fn shortest(active: &[BindingConstraint], r: &Vector4<f64>) -> (usize, f64) {
    let mut first = (0, f64::INFINITY);
    for (position, (held, &rate)) in active.iter().zip(r.iter()).enumerate() {
        if rate > 0.0 && held.multiplier / rate < first.1 {
            first = (position, held.multiplier / rate);
        }
    }
    first
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at_least(normal: [f64; 4], bound: f64) -> LinearConstraint {
        LinearConstraint { normal: Vector4::from(normal), bound }
    }

    #[test]
    fn a_corner_by_pencil() {
        // Nearest point to the origin with x >= 1, x + y >= 3: (1.5, 1.5), only the second binds.
        let constraints =
            [at_least([1.0, 0.0, 0.0, 0.0], 1.0), at_least([1.0, 1.0, 0.0, 0.0], 3.0)];
        let solution = minimise(&Matrix4::identity(), &Vector4::zeros(), &constraints).unwrap();
        assert!((solution.x - Vector4::new(1.5, 1.5, 0.0, 0.0)).norm() < 1e-14);
        assert!(solution.multipliers[0].abs() < 1e-14);
        assert!((solution.multipliers[1] - 1.5).abs() < 1e-14);
    }

    #[test]
    fn contradicting_constraints_have_no_solution() {
        let constraints =
            [at_least([1.0, 0.0, 0.0, 0.0], 1.0), at_least([-1.0, 0.0, 0.0, 0.0], 0.0)];
        assert!(minimise(&Matrix4::identity(), &Vector4::zeros(), &constraints).is_none());
    }

    #[test]
    fn a_constraint_that_entered_early_may_leave() {
        // The steep one is violated most at first, the final corner is the other one's alone.
        let constraints =
            [at_least([0.0, 1.0, 0.0, 0.0], 2.0), at_least([0.1, 1.0, 0.0, 0.0], 30.0)];
        let solution = minimise(&Matrix4::identity(), &Vector4::zeros(), &constraints).unwrap();
        let scale = 30.0 / 1.01;
        assert!((solution.x - Vector4::new(0.1, 1.0, 0.0, 0.0) * scale).norm() < 1e-12);
    }
}
