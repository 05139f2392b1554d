//! Machine and inverse against closed forms, joint lists and random chains.

#![expect(clippy::unwrap_used, clippy::panic, reason = "a test stops on surprise")]

use crate::chains;
use crate::property;

use chains::{V3, axis, cases, joints, layout, number, numbers, pose, spec, vector};
use nalgebra::{Rotation3, UnitVector3};
use num_dual::{Dual3_64, DualNum};
use proptest::prelude::*;
use serde_json::Value;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI, TAU};
use trunnion::feed::{Limits, ceiling};
use trunnion::files::machine::{BUILT_IN, parse};
use trunnion::inverse::{Branch, Inverse, InverseError, InverseSolutions};
use trunnion::machine::{Kinematics, Machine, Setup};
use trunnion::math::angle::{angle_between, wrap};
use trunnion::math::jet::{Jet, Real, by_arc_length};
use trunnion::types::{AxisVector, PoseRates};

/// Distance of two axis positions, whole turns ignored.
fn apart(a: &AxisVector, b: &AxisVector) -> [f64; 2] {
    let d = a - b;
    [d.fixed_rows::<3>(0).norm(), wrap(d[3]).abs().max(wrap(d[4]).abs())]
}

fn both(inverse: &Inverse, tip: V3, axis: V3) -> Vec<AxisVector> {
    match inverse.solutions(&pose(tip, axis)).unwrap() {
        InverseSolutions::Regular(both) => both.to_vec(),
        InverseSolutions::Singular(one) => vec![one],
    }
}

#[test]
fn the_twelve_layouts_are_chains() {
    let mut codes = std::collections::BTreeSet::new();
    for case in cases("layouts.json") {
        let (kinematics, [first, second]) = layout(&case);
        let inverse = Inverse::new(&kinematics).unwrap();
        let [tip, axis] = [vector(&case["tip"]), vector(&case["axis"])];
        let tol = |key: &str| number(&case["tol"][key]);
        let expected: Vec<AxisVector> = case["solutions"]
            .as_array()
            .unwrap()
            .iter()
            .map(|solution| {
                let mut q = AxisVector::zeros();
                q.fixed_rows_mut::<3>(0).copy_from(&vector(&solution["xyz"]));
                q[first] = number(&solution["first"]);
                q[second] = number(&solution["second"]);
                q
            })
            .collect();
        for q in &expected {
            let there = kinematics.forward(q);
            assert!((there.tip.coords - tip).norm() <= tol("fk_mm"), "{} {there:?}", case["id"]);
            assert!((*there.axis - axis).norm() <= tol("fk_axis"), "{}", case["id"]);
        }
        if case["singular"] == true {
            let hold = number(&case["hold_work_side_axis"]);
            let near = AxisVector::from([0.0, 0.0, 0.0, hold, 0.0]);
            let q = inverse.near(&pose(tip, axis), &near).unwrap();
            let [mm, rad] = apart(&q, &expected[0]);
            assert!(
                mm <= tol("ik_mm") && rad <= tol("ik_rad"),
                "{} {q} {}",
                case["id"],
                expected[0]
            );
        } else {
            let found = both(&inverse, tip, axis);
            assert_eq!(found.len(), expected.len());
            for q in &expected {
                let hit = found
                    .iter()
                    .map(|f| apart(f, q))
                    .any(|[mm, rad]| mm <= tol("ik_mm") && rad <= tol("ik_rad"));
                assert!(hit, "{}: {q} not among {found:?}", case["id"]);
            }
        }
        let names = [first, second].map(|axis| kinematics.machine().axes[axis].name.as_str());
        assert_eq!(names, ["first_axis", "second_axis"].map(|key| case[key].as_str().unwrap()));
        // How many rotaries stand between workpiece and slides.
        let kind = ["head-head", "table-head", "table-table"];
        let stage = kinematics.chain().stage;
        assert!(
            stage.iter().all(|&stage| case["type"] == kind[stage]),
            "{} {stage:?}",
            case["type"]
        );
        let distance = inverse.pole_distance(&pose(tip, axis).axis);
        let expected = number(&case["angle_to_singular_axis"]);
        assert!((distance - expected).abs() <= tol("fk_axis"), "{}: {distance}", case["id"]);
        codes.insert(case["layout"].as_u64().unwrap());
    }
    assert_eq!(codes.len(), 12);
}

/// Slide positions of paper 002's three types, put right (CT1, CT2, CT3 of docs/sources.md).
#[test]
fn slide_positions_of_the_three_types() {
    for case in cases("layouts.json").iter().filter(|case| case["table_sign"] == 1) {
        let [l, r, t] = ["L", "R", "T"].map(|key| vector(&case[key]));
        let d = vector(&case["tip"]) - l;
        for solution in case["solutions"].as_array().unwrap() {
            let [a, b] = ["first", "second"].map(|key| number(&solution[key]));
            let [sa, ca, sb, cb] = [a.sin(), a.cos(), b.sin(), b.cos()];
            let closed = match case["layout"].as_u64().unwrap() {
                11 => V3::new(
                    d.x - r.x - (t.x * cb + t.z * sb),
                    d.y - (r.y * ca - r.z * sa) - (t.x * sa * sb + t.y * ca - t.z * sa * cb),
                    d.z - (r.y * sa + r.z * ca) - (-t.x * ca * sb + t.y * sa + t.z * ca * cb),
                ),
                21 => {
                    let h = -d.x * sb + d.z * cb + r.z;
                    V3::new(
                        d.x * cb + d.z * sb + r.x - t.x,
                        (d.y + r.y) * ca - h * sa - t.y,
                        (d.y + r.y) * sa + h * ca - t.z,
                    )
                }
                31 => V3::new(
                    d.x - r.x - (t.x * cb + t.z * sb),
                    d.y * ca - d.z * sa - r.y - t.y,
                    d.y * sa + d.z * ca - r.z - (-t.x * sb + t.z * cb),
                ),
                _ => continue,
            };
            let (kinematics, [first, second]) = layout(case);
            let inverse = Inverse::new(&kinematics).unwrap();
            let mut near = AxisVector::zeros();
            near[first] = a;
            near[second] = b;
            let q =
                inverse.near(&pose(vector(&case["tip"]), vector(&case["axis"])), &near).unwrap();
            assert!((q.fixed_rows::<3>(0) - closed).norm() < 1e-9, "{}", case["id"]);
        }
    }
}

#[test]
fn joint_lists_in_any_order() {
    let cases = cases("general.json");
    for case in &cases {
        let described = cases.iter().find(|other| {
            other["machine"].is_object() && other["machine_name"] == case["machine_name"]
        });
        let kinematics = joints(&described.unwrap()["machine"]);
        let inverse = Inverse::new(&kinematics).unwrap();
        let of = |values: &Value| {
            AxisVector::from(
                kinematics
                    .machine()
                    .axes
                    .each_ref()
                    .map(|axis| number(&values[axis.name.as_str()])),
            )
        };
        let [tip, axis] = [vector(&case["tip"]), vector(&case["axis"])];
        let [mm, rad] = [number(&case["tol"]["mm"]), number(&case["tol"]["rad"])];
        let there = kinematics.forward(&of(&case["joint_values"]));
        assert!((there.tip.coords - tip).norm() <= mm && (*there.axis - axis).norm() <= rad);
        let found = both(&inverse, tip, axis);
        for solution in case["solutions"].as_array().unwrap() {
            let hit = found.iter().map(|q| apart(q, &of(solution)));
            assert!(hit.into_iter().any(|[d, a]| d <= mm && a <= rad), "{} {found:?}", case["id"]);
        }
    }
    for reach in self::cases("reach.json") {
        let described = cases.iter().find(|case| {
            case["machine"].is_object() && case["machine_name"] == reach["machine_name"]
        });
        let kinematics = joints(&described.unwrap()["machine"]);
        let chain = kinematics.chain();
        // As the axes are given: the chain has `sense` in its directions.
        let sense = |joint: usize| kinematics.machine().axes[3 + joint].sense;
        let [w1, w2] = [0, 1]
            .map(|joint| UnitVector3::new_normalize(chain.rotary[joint].dir.scale(sense(joint))));
        for (key, [a, b]) in [("angle_w1_w2", [w1, w2]), ("angle_w2_o0", [w2, chain.axis])] {
            let angle = angle_between(&a, &b);
            assert!((angle - number(&reach[key])).abs() < 1e-15, "{} {key} {angle}", reach["id"]);
        }
        let [low, high] = Inverse::new(&kinematics).unwrap().reach().ends();
        assert!((low - number(&reach["polar_min"])).abs() < 1e-15);
        assert!((high - number(&reach["polar_max"])).abs() < 1e-15);
    }
}

/// A 45° nutating head reaches 0..90°; what is beyond misses by the angle beyond.
#[test]
fn a_miss_is_measured() {
    let kinematics = nutating();
    let inverse = Inverse::new(&kinematics).unwrap();
    let below = V3::new(0.6_f64.cos(), 0.0, -(0.6_f64.sin()));
    let error = inverse.solutions(&pose(V3::zeros(), below)).unwrap_err();
    let InverseError::Unreachable { nearest, miss, .. } = error else { panic!("{error}") };
    assert!((miss - 0.6).abs() < 1e-15);
    assert!(angle_between(&nearest, &V3::x_axis()) < 1e-15);
    assert!(inverse.solutions(&pose(V3::zeros(), *nearest)).is_ok());
}

fn nutating() -> Kinematics {
    let mut axes = chains::slides();
    axes.push(axis("C", V3::z(), Some(V3::new(0.0, 0.0, -900.0))));
    axes.push(axis(
        "B",
        V3::new(0.0, FRAC_PI_4.sin(), FRAC_PI_4.cos()),
        Some(V3::new(0.0, 120.0, 180.0)),
    ));
    let spec = spec(&["C", "b", "X", "Y", "Z", "B"], axes, V3::new(0.0, 0.0, -120.0), V3::z());
    Kinematics::new(&Machine::new(spec).unwrap(), &Setup::new(V3::zeros(), [0.0; 3], 0.0))
}

/// Polynomial with ascending coefficients as a jet.
fn polynomial(coefficients: &Value, u: f64) -> Jet {
    let u = Jet::variable(u);
    numbers(coefficients).iter().rev().fold(Jet::constant(0.0), |sum, &c| sum * u + c)
}

fn rates(tip: [Jet; 3], axis: [Jet; 3]) -> PoseRates {
    let rows = |jets: [Jet; 3]| {
        let d = jets.map(Jet::derivatives);
        [0, 1, 2, 3].map(|order| V3::from(d.map(|row| row[order])))
    };
    PoseRates { tip: rows(tip), axis: rows(axis), contact: [V3::zeros(); 4] }
}

fn three(value: &Value, u: f64) -> [Jet; 3] {
    let rows = value.as_array().unwrap();
    [0, 1, 2].map(|row| polynomial(&rows[row], u))
}

/// Largest difference relative to the larger of the two vectors.
fn relative(a: &AxisVector, b: &AxisVector) -> f64 {
    (a - b).amax() / b.amax().max(1e-300)
}

/// In the order of the case: X, Y, Z, first, second.
fn reorder(q: &AxisVector, [first, second]: [usize; 2]) -> AxisVector {
    AxisVector::from([q[0], q[1], q[2], q[first], q[second]])
}

#[test]
fn derivatives_by_arc_length_on_the_twelve_layouts() {
    for case in cases("coordinated_motion.json") {
        let (kinematics, order) = layout(&case);
        let inverse = Inverse::new(&kinematics).unwrap();
        let u = number(&case["u"]);
        let rates = rates(three(&case["P_poly"], u), three(&case["D_poly"], u));
        let of = |key: &str| AxisVector::from_column_slice(&numbers(&case[key]));
        let tol = |key: &str| number(&case["tol"][key]);
        let q = Branch::BOTH.map(|branch| inverse.jets(&rates, branch).unwrap());
        let on = |q: &[AxisVector; 4]| apart(&reorder(&q[0], order), &of("q"));
        let q = q.iter().find(|q| on(q)[1] < 1e-6).unwrap();
        let [mm, rad] = on(q);
        assert!(mm <= tol("pos") && rad <= tol("pos"), "{} {mm} {rad}", case["id"]);
        let [p1, p2, p3] = [rates.tip[1], rates.tip[2], rates.tip[3]];
        let [t, k, l] = by_arc_length([q[1], q[2], q[3]], [p1, p2, p3]).unwrap();
        let [t, k, l] = [t, k, l].map(|row| reorder(&row, order));
        assert!(relative(&t, &of("t")) <= tol("rel_vel"), "{} {t}", case["id"]);
        assert!(relative(&k, &of("K")) <= tol("rel_acc"), "{} {k}", case["id"]);
        assert!(relative(&l, &of("L3")) <= tol("rel_jerk"), "{} {l}", case["id"]);
        let [v, a, j] = ["V", "A", "J"].map(|key| number(&case[key]));
        assert!(relative(&(t * v), &of("qd")) <= tol("rel_vel"));
        assert!(relative(&(t * a + k * v * v), &of("qdd")) <= tol("rel_acc"));
        let jerk = t * j + k * (3.0 * v * a) + l * v.powi(3);
        assert!(relative(&jerk, &of("qddd")) <= tol("rel_jerk"), "{} {jerk}", case["id"]);
        let there = rates.pose().unwrap();
        assert!((there.tip.coords - vector(&case["Q"])).norm() <= tol("pos"), "{}", case["id"]);
        assert!((*there.axis - vector(&case["O"])).norm() <= tol("pos"), "{}", case["id"]);
        let limit = |key: &str| AxisVector::from_column_slice(&numbers(&case["limits"][key]));
        let limits = Limits {
            velocity: limit("vmax"),
            rapid: limit("vmax"),
            acceleration: limit("amax"),
            jerk: None,
            minus: None,
        };
        let found = ceiling(&t, &k, &limits);
        let off = |found: f64, key: &str| (found / number(&case[key]) - 1.0).abs();
        assert!(off(found.velocity, "feed_limit_velocity") <= tol("rel_vel"), "{found:?}");
        assert!(off(found.acceleration, "feed_limit_acceleration") <= tol("rel_acc"), "{found:?}");
    }
}

/// Paper 000: C-A head on a fixed bed, the table moves x and y; its tool vector is pivot -> tip.
#[test]
fn the_machine_of_paper_000() {
    for case in cases("head_fixed_bed.json") {
        let pivot = V3::new(0.0, 0.0, -number(&case["d2"]));
        let mut axes = chains::slides();
        axes[0].sense = -1.0;
        axes[1].sense = -1.0;
        axes.push(axis("C", V3::z(), Some(pivot)));
        axes.push(axis("A", V3::x(), Some(pivot)));
        let spec = spec(&["X", "Y", "b", "Z", "C", "A"], axes, V3::zeros(), V3::z());
        let setup = Setup::new(V3::zeros(), [0.0; 3], 0.0);
        let kinematics = Kinematics::new(&Machine::new(spec).unwrap(), &setup);
        let inverse = Inverse::new(&kinematics).unwrap();
        let u = number(&case["u"]);
        let theta = case["theta"].as_array().unwrap();
        let [(s1, c1), (s2, c2)] = [0, 1].map(|row| polynomial(&theta[row], u).sin_cos());
        let rates = rates(three(&case["P"], u), [s2 * s1, -(s2 * c1), c2]);
        let of = |key: &str| AxisVector::from_column_slice(&numbers(&case[key]));
        let q = Branch::BOTH.map(|branch| inverse.jets(&rates, branch).unwrap());
        let q = q.iter().find(|q| apart(&q[0], &of("q"))[1] < 1e-6).unwrap();
        let tol = number(&case["tol"]["rel"]);
        assert!(relative(&q[0], &of("q")) <= tol, "{} {}", q[0], of("q"));
        let tip = [rates.tip[1], rates.tip[2], rates.tip[3]];
        let [t, k, _] = by_arc_length([q[1], q[2], q[3]], tip).unwrap();
        assert!(relative(&t, &of("t")) <= tol && relative(&k, &of("K")) <= tol);
        let [v, a] = [number(&case["V"]), number(&case["A"])];
        assert!(relative(&(t * v), &of("qd")) <= tol);
        assert!(relative(&(t * a + k * v * v), &of("qdd")) <= tol);
        let by_hand = slides_of_paper_000(number(&case["d2"]), &[q[0], t, k], tip, &rates.tip[0]);
        for (found, by_hand) in [q[0], t, k].iter().zip(by_hand) {
            let off = (found.fixed_rows::<3>(0) - by_hand).amax() / by_hand.amax().max(1.0);
            assert!(off <= tol, "{}: {found} {by_hand}", case["id"]);
        }
    }
}

/// Slides of paper 000, and their first two derivatives by arc length, from rotaries C, A: equations
/// (28)-(30) and (37)-(39) put right (docs/sources.md#000), Z from the tip instead of the pivot.
fn slides_of_paper_000(d2: f64, q: &[AxisVector; 3], tip: [V3; 3], p: &V3) -> [V3; 3] {
    let [q, t, k] = q;
    let ([s1, c1], [s2, c2]) = ([q[3].sin(), q[3].cos()], [q[4].sin(), q[4].cos()]);
    let ([t1, t2], [k1, k2]) = ([t[3], t[4]], [k[3], k[4]]);
    let [pt, pk, _] = by_arc_length([tip[0], tip[1], tip[2]], tip).unwrap();
    [
        V3::new(-p.x + d2 * s2 * s1, -p.y - d2 * s2 * c1, p.z + d2 * (1.0 - c2)),
        V3::new(
            -pt.x + d2 * (c2 * s1 * t2 + s2 * c1 * t1),
            -pt.y - d2 * (c2 * c1 * t2 - s2 * s1 * t1),
            pt.z + d2 * s2 * t2,
        ),
        V3::new(
            -pk.x + d2 * (c2 * s1 * k2 + s2 * c1 * k1) - d2 * s2 * s1 * (t1 * t1 + t2 * t2)
                + 2.0 * d2 * c2 * c1 * t1 * t2,
            -pk.y - d2 * (c2 * c1 * k2 - s2 * s1 * k1)
                + d2 * s2 * c1 * (t1 * t1 + t2 * t2)
                + 2.0 * d2 * c2 * s1 * t1 * t2,
            pk.z + d2 * s2 * k2 + d2 * c2 * t2 * t2,
        ),
    ]
}

/// Paper 000 runs a cubic through four joint angles and takes their rates from it (eq. 17, 18 put
/// right). The exact jets tell by how much that is off: angles as the fourth power of the stretch, rates
/// as the third, accelerations as the square only.
#[test]
fn cubics_through_joint_angles_are_off() {
    let mut axes = chains::slides();
    axes.push(axis("C", V3::z(), Some(V3::zeros())));
    axes.push(axis("A", V3::x(), Some(V3::zeros())));
    let spec = spec(&["b", "X", "Y", "Z", "C", "A"], axes, V3::zeros(), V3::z());
    let setup = Setup::new(V3::zeros(), [0.0; 3], 0.0);
    let inverse = Inverse::new(&Kinematics::new(&Machine::new(spec).unwrap(), &setup)).unwrap();
    let exact = |u: f64| {
        let u = Jet::variable(u);
        let axis = [u * 0.5 + 0.3, u * u * 0.3 + u * -0.2 + 0.4, Jet::constant(0.8)];
        inverse.jets(&rates([Jet::constant(0.0); 3], axis), Branch::Plus).unwrap()
    };
    // Largest errors of angle, rate and acceleration over [0, h].
    let off = |h: f64| {
        let at = [0.0, 1.0, 2.0, 3.0].map(|i| exact(h * i / 3.0)[0]);
        // Newton's divided differences, with the third of the stretch as unit.
        let [d1, d2] = [at[1] - at[0], (at[2] - at[1] * 2.0 + at[0]) / 2.0];
        let d3 = (at[3] - at[2] * 3.0 + at[1] * 3.0 - at[0]) / 6.0;
        let mut worst = [0.0_f64; 3];
        for i in 0..=200 {
            let x = 3.0 * f64::from(i) / 200.0;
            let third = h / 3.0;
            let cubic = [
                at[0] + d1 * x + d2 * (x * (x - 1.0)) + d3 * (x * (x - 1.0) * (x - 2.0)),
                (d1 + d2 * (2.0 * x - 1.0) + d3 * (3.0 * x * x - 6.0 * x + 2.0)) / third,
                (d2 * 2.0 + d3 * (6.0 * x - 6.0)) / (third * third),
            ];
            for (order, q) in cubic.iter().enumerate() {
                let error = (q - exact(x * third)[order]).fixed_rows::<2>(3).amax();
                worst[order] = worst[order].max(error);
            }
        }
        worst
    };
    let [angle, rate, acceleration] = off(0.125);
    // In rad, rad per u, rad per u^2, beside jets that are exact to 1e-12.
    for (found, expected) in [(angle, 3.26e-6), (rate, 4.71e-4), (acceleration, 4.16e-2)] {
        assert!((found / expected - 1.0).abs() < 0.01, "{found:e} {expected:e}");
    }
    let half = off(0.0625);
    for (order, (whole, half)) in [angle, rate, acceleration].iter().zip(half).enumerate() {
        let power = (whole / half).log2();
        let expected = [4.0, 3.0, 2.0][order];
        assert!((power - expected).abs() < 0.4, "order {order}: {power}");
    }
}

/// A great circle at a distance from the pole: extremes of the free axis' derivatives.
#[test]
fn past_a_pole() {
    for case in cases("singular_pass.json") {
        let mut axes = chains::slides();
        axes.push(axis("C", V3::z(), Some(V3::zeros())));
        axes.push(axis("A", V3::x(), Some(V3::zeros())));
        let spec = spec(&["b", "X", "Y", "Z", "C", "A"], axes, V3::zeros(), V3::z());
        let setup = Setup::new(V3::zeros(), [0.0; 3], 0.0);
        let inverse = Inverse::new(&Kinematics::new(&Machine::new(spec).unwrap(), &setup)).unwrap();
        let delta = number(&case["delta_deg"]).to_radians();
        let at = |s: f64| {
            let (sin, cos) = Jet::variable(s).sin_cos();
            let axis = [cos * delta.sin(), sin, cos * delta.cos()];
            inverse.jets(&rates([Jet::constant(0.0); 3], axis), Branch::Plus).unwrap()
        };
        let tol = number(&case["tol"]["rel"]);
        assert!((at(0.0)[1][3] / number(&case["max_dtheta"]) - 1.0).abs() < tol);
        let third = at(0.0)[3][3].abs() * delta.sin().powi(3);
        let limit = number(&case["max_d3theta_times_sin3_limit"]) * delta.cos().powi(2);
        assert!((third / limit - 1.0).abs() < tol);
        let second = (0..2000).map(|i| at(f64::from(i) * 1e-4)[2][3].abs()).fold(0.0, f64::max);
        let limit = number(&case["max_d2theta_times_sin2_limit"]);
        assert!((second * delta.sin().powi(2) / limit - 1.0).abs() < 0.02);
        let sweep = at(0.5)[0][3] - at(-0.5)[0][3];
        assert!((sweep / number(&case["azimuth_sweep_rad_for_s_pm_0p5"]) - 1.0).abs() < tol);
    }
}

fn unit_vector() -> impl Strategy<Value = V3> {
    let any = prop::array::uniform3(-1.0..1.0f64).prop_map(V3::from);
    any.prop_filter("not too short", |v| (0.1..1.0).contains(&v.norm())).prop_map(|v| v.normalize())
}

fn point(size: f64) -> impl Strategy<Value = V3> {
    prop::array::uniform3(-size..size).prop_map(V3::from)
}

/// Any order of five axes and the bed, any directions that are not degenerate, any setup.
fn random_chain() -> impl Strategy<Value = Kinematics> {
    let order = Just(vec!["b", "X", "Y", "Z", "P", "S"]).prop_shuffle();
    let slides = prop::array::uniform3(unit_vector())
        .prop_filter("a frame", |[x, y, z]| x.cross(y).dot(z).abs() > 0.2);
    let rotary = (unit_vector(), unit_vector(), unit_vector()).prop_filter("skew", |(p, s, o)| {
        p.cross(s).norm() > 0.1 && s.cross(o).norm() > 0.1 && p.cross(o).norm() > 0.1
    });
    let points = prop::array::uniform4(point(500.0));
    let senses = prop::array::uniform5(prop::bool::ANY);
    (order, slides, rotary, points, senses, point(3.0)).prop_map(
        |(order, slides, (p, s, o), [pp, ps, tip, origin], senses, turn)| {
            let mut axes: Vec<_> = ["X", "Y", "Z"]
                .iter()
                .zip(slides)
                .map(|(name, dir)| axis(name, dir, None))
                .collect();
            axes.extend([axis("P", p, Some(pp)), axis("S", s, Some(ps))]);
            for (axis, positive) in axes.iter_mut().zip(senses) {
                axis.sense = if positive { 1.0 } else { -1.0 };
            }
            // The tool-side rotary must not be parallel to the tool, whichever it is.
            let machine = Machine::new(spec(&order, axes, tip, o)).unwrap();
            Kinematics::new(&machine, &Setup::new(origin, turn.into(), 17.0))
        },
    )
}

/// Worst error of `forward(inverse(pose))` over all solutions: mm, rad, and whether some solution
/// is `q` itself.
fn round_trip(kinematics: &Kinematics, q: &AxisVector) -> Option<([f64; 2], [f64; 2])> {
    let inverse = Inverse::new(kinematics).unwrap();
    let there = kinematics.forward(q);
    let solutions = match inverse.solutions(&there) {
        Ok(InverseSolutions::Regular(both)) => both.to_vec(),
        Ok(InverseSolutions::Singular(one)) => vec![one],
        Err(InverseError::FlatSlides { .. }) => return None,
        Err(error) => panic!("{error}"),
    };
    let mut worst = [0.0_f64; 2];
    let mut nearest = [f64::INFINITY; 2];
    for solution in &solutions {
        let again = kinematics.forward(solution);
        // Slides that nearly lie in one plane reach far; rounding grows with where they are.
        let scale = 1.0_f64.max(solution.fixed_rows::<3>(0).norm() / 1e3);
        worst[0] = worst[0].max((again.tip - there.tip).norm() / scale);
        worst[1] = worst[1].max(angle_between(&again.axis, &there.axis));
        let [mm, rad] = apart(solution, q);
        if rad < nearest[1] {
            nearest = [mm, rad];
        }
    }
    Some((worst, nearest))
}

proptest! {
    #![proptest_config(property::cases(1500))]

    /// Forward of inverse is the pose, on both branches, and one of them is where it came from.
    #[test]
    fn any_chain_there_and_back(
        kinematics in random_chain(),
        slides in prop::array::uniform3(-400.0..400.0f64),
        rotary in prop::array::uniform2(-PI..PI),
    ) {
        let q = AxisVector::from([slides[0], slides[1], slides[2], rotary[0], rotary[1]]);
        if let Some(([mm, rad], nearest)) = round_trip(&kinematics, &q) {
            prop_assert!(mm <= 1e-9 && rad <= 1e-12, "tip off by {mm:e} mm, axis by {rad:e}");
            // Near the rim both branches meet and the angle is only good to the root of rounding.
            prop_assert!(nearest[1] < 1e-6, "own branch missed by {:e} rad", nearest[1]);
        }
    }

    /// However close to the pole.
    #[test]
    fn near_the_pole(
        exponent in 1.0..14.0f64,
        azimuth in -PI..PI,
        tip in point(300.0),
        which in 0..60usize,
        down in prop::bool::ANY,
    ) {
        let case = &cases("layouts.json")[which];
        let (kinematics, _) = layout(case);
        let inverse = Inverse::new(&kinematics).unwrap();
        let poles = inverse.singular_directions();
        prop_assert_eq!(poles.len(), 2);
        let pole = poles[usize::from(down)];
        let side = pole.cross(&V3::new(0.3, 0.5, 0.7)).normalize();
        let tilt = Rotation3::from_axis_angle(&UnitVector3::new_normalize(side), 10f64.powf(-exponent));
        let there = pose(tip, Rotation3::from_axis_angle(&pole, azimuth) * (tilt * *pole));
        for q in both(&inverse, there.tip.coords, *there.axis) {
            let again = kinematics.forward(&q);
            prop_assert!((again.tip - there.tip).norm() <= 1e-9);
            prop_assert!(angle_between(&again.axis, &there.axis) <= 1e-12);
        }
    }

    /// The inverse continues from where the machine is, turn and branch.
    #[test]
    fn continuing_a_branch_stays_on_it(
        which in 0..60usize,
        rotary in prop::array::uniform2(0.2..1.3f64),
        turns in prop::array::uniform2(-3i32..4),
        tip in point(300.0),
    ) {
        let (kinematics, _) = layout(&cases("layouts.json")[which]);
        let inverse = Inverse::new(&kinematics).unwrap();
        let turn = |row: usize| rotary[row] + f64::from(turns[row]) * std::f64::consts::TAU;
        let q = AxisVector::from([tip.x, tip.y, tip.z, turn(0), turn(1)]);
        let near = q.add_scalar(0.01);
        let found = inverse.near(&kinematics.forward(&q), &near).unwrap();
        prop_assert!((found - q).amax() < 1e-9, "{found} {q}");
        let inside = inverse.near_inside(&kinematics.forward(&q), &near).unwrap();
        prop_assert!((inside - q).amax() < 1e-9);
    }
}

proptest! {
    #![proptest_config(property::cases(600))]

    /// Inside travel, no branch and no turn is nearer; from positions that tie as well.
    #[test]
    fn continuing_inside_travel_is_nearest_by_brute_force(
        which in 0..16usize,
        share in prop::array::uniform5(0.0..=1.0f64),
        before in prop::array::uniform2(-3.0..3.0f64),
        tie in 0..4u8,
    ) {
        let machine = parse(BUILT_IN[which].1).unwrap().machine;
        let setup = Setup::new(V3::new(10.0, -20.0, 30.0), [0.0; 3], 80.0);
        let kinematics = Kinematics::new(&machine, &setup);
        let inverse = Inverse::new(&kinematics).unwrap();
        let travel = |index: usize| {
            let [low, high] = machine.axes[index].limits.ends();
            if low.is_finite() { [low, high] } else { [-10.0, 10.0] }
        };
        let q = AxisVector::from_fn(|row, _| {
            let [low, high] = travel(row);
            low + (high - low) * share[row]
        });
        let mut near = machine.home();
        // Half a turn away from a solution both ways round are as near.
        near[3] = if tie == 0 { q[3] + PI } else { before[0] * 4.0 };
        near[4] = before[1];
        let there = kinematics.forward(&q);
        let found = inverse.continued(&there, &near).unwrap();
        prop_assert!(machine.out_of_travel(&found.q).is_none());
        prop_assert!((kinematics.forward(&found.q).tip - there.tip).norm() <= 1e-9);
        let rotary = |q: &AxisVector| (q - near).fixed_rows::<2>(3).abs().sum();
        let InverseSolutions::Regular(both) = inverse.solutions(&there).unwrap() else { return Ok(()) };
        for (base, first, second) in both
            .iter()
            .flat_map(|base| (-4..=4).flat_map(move |i| (-4..=4).map(move |j| (base, i, j))))
        {
            let mut other = *base;
            other[3] += TAU * f64::from(first);
            other[4] += TAU * f64::from(second);
            if machine.out_of_travel(&other).is_none() {
                let nearer = rotary(&found.q) - rotary(&other);
                prop_assert!(nearer <= 1e-8, "{nearer} rad nearer: {other} than {}", found.q);
            }
        }
        if let Some(branch) = found.branch {
            let [_, angle] = apart(&both[usize::from(branch == Branch::Minus)], &found.q);
            prop_assert!(angle < 1e-9, "not on {branch:?}");
        }
    }
}

/// The property test itself must be able to fail: one wrong sign in one branch is seen.
#[test]
fn a_planted_wrong_sign_is_caught() {
    let kinematics = nutating();
    let inverse = Inverse::new(&kinematics).unwrap();
    let there = pose(V3::new(10.0, 20.0, 30.0), V3::new(0.3, -0.2, 0.9));
    let InverseSolutions::Regular(both) = inverse.solutions(&there).unwrap() else { panic!() };
    for good in both {
        for flipped in 0..5 {
            let mut q = good;
            q[flipped] = -q[flipped];
            let again = kinematics.forward(&q);
            let off = (again.tip - there.tip).norm() + angle_between(&again.axis, &there.axis);
            assert!(off > 1e-3, "axis {flipped} reversed goes unnoticed");
        }
    }
}

/// The dual numbers' own `atan2` goes through `y / x`, whose derivatives cancel where `x` is small.
fn dual_atan2(y: Dual3_64, x: Dual3_64) -> Dual3_64 {
    if x.re.abs() >= y.re.abs() { y.atan2(x) } else { -(x / y).atan() + FRAC_PI_2.copysign(y.re) }
}

/// Layout 11 by hand on another library's third-order dual numbers: A from the base, then B
/// (angles of the table in docs/sources.md#002, slides CT1).
fn layout_11([l, r, t]: [V3; 3], tip: [Dual3_64; 3], axis: [Dual3_64; 3], s: f64) -> [Dual3_64; 5] {
    let [x, y, z] = axis;
    let length = (x * x + y * y + z * z).sqrt();
    let [i, j, k] = [x / length, y / length, z / length];
    let a = dual_atan2(j * -s, k * s);
    let b = dual_atan2(i, (j * j + k * k).sqrt() * s);
    let [(sa, ca), (sb, cb)] = [a.sin_cos(), b.sin_cos()];
    let d = [tip[0] - l.x, tip[1] - l.y, tip[2] - l.z];
    [
        d[0] - r.x - (cb * t.x + sb * t.z),
        d[1] - (ca * r.y - sa * r.z) - (sa * sb * t.x + ca * t.y - sa * cb * t.z),
        d[2] - (sa * r.y + ca * r.z) - (sa * t.y - ca * sb * t.x + ca * cb * t.z),
        a,
        b,
    ]
}

proptest! {
    #![proptest_config(property::cases(400))]

    /// Three derivatives on both branches against dual numbers through the closed form.
    #[test]
    fn jets_against_dual_numbers(
        which in 0..5usize,
        tip in prop::array::uniform9(-50.0..50.0f64),
        bend in prop::array::uniform9(-0.5..0.5f64),
        u in -1.0..1.0f64,
    ) {
        let case = &cases("layouts.json")[which];
        let (kinematics, _) = layout(case);
        let inverse = Inverse::new(&kinematics).unwrap();
        let (tip, axis) = (tip.to_vec(), bend.to_vec());
        let dual_at = |c: &[f64], start: f64, row: usize| {
            let u = Dual3_64::new(u, 1.0, 0.0, 0.0);
            (u * c[3 * row] + c[3 * row + 1]) * u * u + u * c[3 * row + 2] + start
        };
        let jet_at = |c: &[f64], start: f64, row: usize| {
            let u = Jet::variable(u);
            (u * c[3 * row] + c[3 * row + 1]) * u * u + u * c[3 * row + 2] + start
        };
        let rates = rates(
            [0, 1, 2].map(|row| jet_at(&tip, 10.0, row)),
            [0, 1, 2].map(|row| jet_at(&axis, 0.6, row)),
        );
        let unit = rates.axis[0].normalize();
        // Clear of the pole, the x axis: derivatives grow with the cube of its nearness.
        prop_assume!(rates.axis[0].norm() > 0.3 && unit.yz().norm() > 0.1);
        let found = Branch::BOTH.map(|branch| inverse.jets(&rates, branch).unwrap());
        let parts = ["L", "R", "T"].map(|key| vector(&case[key]));
        for s in [1.0, -1.0] {
            let tips = [0, 1, 2].map(|row| dual_at(&tip, 10.0, row));
            let axes = [0, 1, 2].map(|row| dual_at(&axis, 0.6, row));
            let by_hand = layout_11(parts, tips, axes, s);
            let rows = [
                AxisVector::from(by_hand.map(|q| q.re)),
                AxisVector::from(by_hand.map(|q| q.v1)),
                AxisVector::from(by_hand.map(|q| q.v2)),
                AxisVector::from(by_hand.map(|q| q.v3)),
            ];
            let q = found.iter().find(|q| apart(&q[0], &rows[0])[1] < 1e-9);
            prop_assert!(q.is_some(), "branch {s}: {} {}", found[0][0], rows[0]);
            // Terms of this size cancel in the derivative of an order, whatever is left of them:
            // a lever of 300 mm turned at the rate at which the azimuth about the pole turns.
            let far = rates.axis[0].norm() * unit.yz().norm();
            let rate = [(1, 1.0), (2, 2.0), (3, 6.0)]
                .map(|(order, factorial)| {
                    let size = rates.axis[order].norm() / (factorial * far);
                    size.powf(1.0 / order as f64)
                })
                .into_iter()
                .fold(0.0, f64::max);
            for (order, row) in (0..).zip(&rows).skip(1) {
                let terms = rates.tip[usize::try_from(order).unwrap()].norm();
                let terms = terms + 1800.0 * f64::powi(rate, order);
                let error = (q.unwrap()[usize::try_from(order).unwrap()] - row).amax() / terms;
                prop_assert!(error < 1e-12, "order {order}: {error:e}");
            }
        }
    }
}
