//! Machine files of the folder `machines/`, compiled in for those who have only the program.

use super::super::walk::nearest;

macro_rules! machine {
    ($name:literal) => {
        ($name, include_str!(concat!("../../../../../machines/", $name, ".toml")))
    };
}

/// Names and texts of the machine files that come with the library, in order of names. Dimensions
/// are typical of their class and taken from no data sheet.
pub const BUILT_IN: [(&str, &str); 19] = [
    machine!("ac-trunnion"),
    machine!("bc-trunnion"),
    machine!("bc-trunnion-bodies"),
    machine!("cb-table-head-bodies"),
    machine!("dmu-nutating45"),
    machine!("gantry-ca-fork"),
    machine!("gantry-ca-fork-bodies"),
    machine!("layout-11-ab-head-head"),
    machine!("layout-12-ba-head-head"),
    machine!("layout-13-ca-head-head"),
    machine!("layout-14-cb-head-head"),
    machine!("layout-21-ab-table-table"),
    machine!("layout-22-ba-table-table"),
    machine!("layout-23-ac-table-table"),
    machine!("layout-24-bc-table-table"),
    machine!("layout-31-ab-table-head"),
    machine!("layout-32-ba-table-head"),
    machine!("layout-33-ca-table-head"),
    machine!("layout-34-cb-table-head"),
];

/// Returns the text of a built-in machine.
///
/// # Errors
///
/// Returns the nearest name, if one may have been meant.
pub fn built_in(name: &str) -> Result<&'static str, Option<&'static str>> {
    let found = BUILT_IN.iter().find(|(known, _)| *known == name);
    // A name may come with a folder and an ending.
    let last = name.rsplit(['/', '\\']).next().unwrap_or(name);
    let bare = last.strip_suffix(".toml").unwrap_or(last);
    found.map(|(_, text)| *text).ok_or_else(|| nearest(bare, &BUILT_IN.map(|(known, _)| known)))
}
