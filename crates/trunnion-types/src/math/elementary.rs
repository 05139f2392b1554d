//! Sine, logarithm and the like in pure Rust: the same bits on every machine and in a page.
//!
//! The functions of the standard library are those of the system: another version of it, another processor or a browser rounds
//! the last bit otherwise, a planner then chooses another of two nearly equal strips, and outputs differ. Square roots, sums and
//! products are exact everywhere, so that they need nothing of the kind.

/// Returns the sine of an angle \[rad\].
#[must_use]
pub fn sin(x: f64) -> f64 {
    libm::sin(x)
}

/// Returns the cosine of an angle \[rad\].
#[must_use]
pub fn cos(x: f64) -> f64 {
    libm::cos(x)
}

/// Returns sine and cosine of an angle \[rad\].
#[must_use]
pub fn sin_cos(x: f64) -> (f64, f64) {
    libm::sincos(x)
}

/// Returns the tangent of an angle \[rad\].
#[must_use]
pub fn tan(x: f64) -> f64 {
    libm::tan(x)
}

/// Returns the angle \[rad\] with this sine, in `[-π/2, π/2]`; NaN outside `[-1, 1]`.
#[must_use]
pub fn asin(x: f64) -> f64 {
    libm::asin(x)
}

/// Returns the angle \[rad\] with this cosine, in `[0, π]`; NaN outside `[-1, 1]`.
#[must_use]
pub fn acos(x: f64) -> f64 {
    libm::acos(x)
}

/// Returns the angle \[rad\] with this tangent, in `[-π/2, π/2]`.
#[must_use]
pub fn atan(x: f64) -> f64 {
    libm::atan(x)
}

/// Returns the angle \[rad\] of the vector `(x, y)` from the x axis, in `[-π, π]`.
#[must_use]
pub fn atan2(y: f64, x: f64) -> f64 {
    libm::atan2(y, x)
}

/// Returns the length of the vector `(x, y)`, also where its square would overflow.
#[must_use]
pub fn hypot(x: f64, y: f64) -> f64 {
    libm::hypot(x, y)
}

/// Returns e to the power of `x`.
#[must_use]
pub fn exp(x: f64) -> f64 {
    libm::exp(x)
}

/// Returns the natural logarithm.
#[must_use]
pub fn ln(x: f64) -> f64 {
    libm::log(x)
}

/// Returns the logarithm to the base 10.
#[must_use]
pub fn log10(x: f64) -> f64 {
    libm::log10(x)
}

/// Returns `x` to the power of `y`.
#[must_use]
pub fn powf(x: f64, y: f64) -> f64 {
    libm::pow(x, y)
}

/// Returns the cube root.
#[must_use]
pub fn cbrt(x: f64) -> f64 {
    libm::cbrt(x)
}

/// Returns the hyperbolic sine.
#[must_use]
pub fn sinh(x: f64) -> f64 {
    libm::sinh(x)
}

/// Returns the hyperbolic cosine.
#[must_use]
pub fn cosh(x: f64) -> f64 {
    libm::cosh(x)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Units in the last place between two numbers.
    fn ulps(a: f64, b: f64) -> u64 {
        a.to_bits().abs_diff(b.to_bits())
    }

    proptest! {
        #[test]
        fn values_are_those_of_the_system_to_the_last_place_or_two(x in -30.0..30.0_f64, y in 1e-9..30.0_f64) {
            let unit = x / 30.0;
            for (ours, theirs) in [
                (sin(x), x.sin()), (cos(x), x.cos()), (sin_cos(x).0, x.sin()), (sin_cos(x).1, x.cos()),
                (tan(x), x.tan()), (asin(unit), unit.asin()), (acos(unit), unit.acos()), (atan(x), x.atan()),
                (atan2(x, y), x.atan2(y)), (hypot(x, y), x.hypot(y)), (exp(x), x.exp()), (ln(y), y.ln()),
                (log10(y), y.log10()), (powf(y, x), y.powf(x)), (cbrt(x), x.cbrt()), (sinh(x), x.sinh()),
                (cosh(x), x.cosh()),
            ] {
                prop_assert!(ulps(ours, theirs) <= 2, "{ours} is not {theirs}");
            }
        }
    }

    /// Bits that every machine has to give: x86-64 and wasm32 do.
    #[test]
    fn bits_are_the_same_everywhere() {
        let sum = (1..=1000_u32).fold(0_u64, |sum, k| {
            let x = f64::from(k) * 0.017;
            let all = [
                sin(x),
                cos(x),
                tan(x),
                asin(x / 20.0),
                acos(x / 20.0),
                atan(x),
                atan2(x, 3.0),
                hypot(x, 0.7),
                exp(x),
                ln(x),
                log10(x),
                powf(x, 1.5),
                cbrt(x),
                sinh(x),
                cosh(x),
            ];
            all.iter().fold(sum, |sum, value| sum.rotate_left(5) ^ value.to_bits())
        });
        assert_eq!(sum, 0x404b_3d3b_0909_c883, "{sum:#x}");
    }
}
