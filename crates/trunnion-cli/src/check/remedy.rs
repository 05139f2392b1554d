//! Remedies of the library as options of the command line.

use trunnion::verify::{VerifyError, VerifyRemedy, offset_short_name};

/// Returns what follows the text of an error: the options that help, or nothing.
pub(super) fn words(error: &VerifyError) -> String {
    match error.remedy() {
        VerifyRemedy::DescribeTools { first } => format!(
            ": describe each, --cutter {first}=R=..,r=.. and --tool-length {first}=L, and so on"
        ),
        VerifyRemedy::DescribeTool { number } => {
            format!("; describe it: --cutter {number}=R=..,r=.. --tool-length {number}=L")
        }
        VerifyRemedy::GiveOffset { number } => {
            let name = offset_short_name(number);
            format!("; give its origin, --offset {name}=X,Y,Z, or that of G54, --offset {name}=G54")
        }
        VerifyRemedy::FlipFaces => {
            "\n  help: turn the faces over with --flip, or leave it out; in a job, part.flip"
                .to_owned()
        }
        _ => String::new(),
    }
}
