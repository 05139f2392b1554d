//! Options of a tool path.

/// Options of the curves through stations. No `Default`: the caller knows the tool.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ToolPathOptions {
    /// Distance from the tip at which a turn of the tool axis counts as movement \[mm per rad\],
    /// for example the outer radius of the cutter. Only used where the contact point (nearly)
    /// stands still while the tool turns about it.
    pub lever: f64,
}
