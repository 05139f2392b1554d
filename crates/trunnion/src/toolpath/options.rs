//! Options of a tool path.

/// Options of the curves through stations. Begin with [`ToolPathOptions::with_lever`] and change the rest by
/// struct update. There is no `Default`: the caller knows the tool.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ToolPathOptions {
    /// Distance from the tip at which a turn of the tool axis counts as movement \[mm per rad\],
    /// for example the outer radius of the cutter. Only used where the contact point (nearly)
    /// stands still while the tool turns about it.
    pub lever: f64,
}

impl ToolPathOptions {
    /// Counts a turn of the tool axis as movement at that distance from the tip \[mm per rad\].
    #[must_use]
    pub const fn with_lever(lever: f64) -> Self {
        Self { lever }
    }
}
