//! The kernel that rounds corners: a quadratic B-spline over -1 to 1.
//!
//! A path that turns by `D` at `x` is `D max(s - x, 0)` besides a straight line. Its convolution with the kernel of
//! half width `w` turns smoothly between `x - w` and `x + w`, and leaves the path elsewhere as it is:
//!
//! ```text
//! p(s) = polyline(s) + D w g((s - x) / w),    g(u) = integral of (u + t)+ k(t) - (u)+
//! ```
//!
//! `g` is even and `g'' = k`, so that curvature is continuous and its change is bounded.
//!
//! Where the curvature jumps by `B`, as between a line and an arc, `B w^2 h(u)` takes the jump away:
//!
//! ```text
//! h(u) = u (1 - |u|)^3 / 12,    h''(0+) = -1/2,    h''(0-) = 1/2
//! ```

/// Returns `g`, `g'`, `g''` and `g'''` at `u`; zeros outside -1 to 1.
pub(super) fn rounding(u: f64) -> [f64; 4] {
    // With knots at 1/2 and 3/2 the B-spline has its usual form.
    let (x, sign) = (1.5 * u.abs(), if u < 0.0 { -1.0 } else { 1.0 });
    if x >= 1.5 {
        return [0.0; 4];
    }
    let [value, slope, bend, change] = if x < 0.5 {
        let ends = 1.0 / 24.0 + 0.5 * (0.5 - x) - 0.375 * (0.25 - x * x);
        let value = ends + (1.0 / 16.0 - x.powi(4)) / 12.0;
        [value, -(0.5 - 0.75 * x + x.powi(3) / 3.0), 0.75 - x * x, -2.0 * x]
    } else {
        let rest = 1.5 - x;
        [rest.powi(4) / 24.0, -rest.powi(3) / 6.0, 0.5 * rest * rest, -rest]
    };
    [value / 1.5, sign * slope, 1.5 * bend, sign * 2.25 * change]
}

/// Returns `h` and its derivatives at `u`; zeros outside -1 to 1.
pub(super) fn bending(u: f64) -> [f64; 4] {
    let (x, sign) = (u.abs(), if u < 0.0 { -1.0 } else { 1.0 });
    if x >= 1.0 {
        return [0.0; 4];
    }
    let y = 1.0 - x;
    let [value, slope, bend, change] =
        [x * y.powi(3), y * y * (y - 3.0 * x), 6.0 * y * (x - y), 18.0 - 24.0 * x];
    [sign * value / 12.0, slope / 12.0, sign * bend / 12.0, change / 12.0]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn derivatives_agree_and_the_kernel_has_weight_one() {
        assert!((rounding(0.0)[0] - 39.0 / 288.0).abs() < 1e-15);
        let h = 1e-5;
        let mut weight = 0.0;
        for k in -1100..1100 {
            let u = f64::from(k) * 1e-3 + 3.3e-4;
            let [low, at, high] = [u - h, u, u + h].map(rounding);
            for order in 0..3 {
                // The slope jumps at the corner, and the path's own turn takes it back.
                if u.abs() > 2e-3 {
                    let slope = (high[order] - low[order]) / (2.0 * h);
                    assert!((slope - at[order + 1]).abs() < 1e-3, "{u} {order}");
                }
            }
            weight += at[2] * 1e-3;
        }
        assert!((weight - 1.0).abs() < 1e-6, "{weight}");
        // Just behind the corner the slope is -1/2, the path's half of its turn.
        assert!((rounding(1e-12)[1] + 0.5).abs() < 1e-9);
    }

    #[test]
    fn the_bend_takes_half_of_the_jump_on_either_side() {
        let h = 1e-5;
        for k in -11..11 {
            let u = f64::from(k) * 0.1 + 0.03;
            let [low, at, high] = [u - h, u, u + h].map(bending);
            for order in 0..3 {
                let slope = (high[order] - low[order]) / (2.0 * h);
                assert!((slope - at[order + 1]).abs() < 1e-3, "{u} {order}");
            }
        }
        let [before, behind] = [-1e-12, 1e-12].map(bending);
        assert!((before[2] - 0.5).abs() < 1e-9 && (behind[2] + 0.5).abs() < 1e-9);
    }
}
