//! How many cases a property is tried with.

use proptest::test_runner::Config;

/// `usual` cases, and in proportion more where `PROPTEST_CASES` asks for more than proptest's own default, as the
/// long runs do. The seed is that of `.cargo/config.toml` unless `PROPTEST_RNG_SEED` says another.
pub(crate) fn cases(usual: u32) -> Config {
    let default = Config::default();
    let times = (default.cases / USUAL_OF_PROPTEST).max(1);
    Config { cases: usual.saturating_mul(times), ..default }
}

/// Cases of a property that asks for none, as proptest's documentation states.
const USUAL_OF_PROPTEST: u32 = 256;
