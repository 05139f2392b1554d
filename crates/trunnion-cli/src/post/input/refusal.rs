//! Errors of posting with their place in the input and the flags that help.

use crate::outcome::Failure;
use std::path::Path;
use trunnion::post::{PostError, PostRemedy};
use trunnion::types::Diagnostic;

/// Returns an error with its line in the input.
pub(super) fn failure(path: &Path, error: &PostError) -> Failure {
    let fault = Diagnostic {
        line: error.line(),
        column: 0,
        message: error.to_string(),
        help: help(error.remedy()).to_owned(),
    };
    Failure::faults(path, &[fault])
}

/// Words a remedy with the flags of this command line.
fn help(remedy: PostRemedy) -> &'static str {
    match remedy {
        PostRemedy::MoveOrRotatePart => {
            "clamp the part elsewhere (--origin), or turn it (--rotation)"
        }
        PostRemedy::RotatePart => "turn the part (--rotation), or post it for another machine",
        PostRemedy::UnwindOrRotatePart => {
            "let the rotaries unwind off the part (--unwind), divide the cut by a rapid move before this line, or turn \
             the part (--rotation)"
        }
        PostRemedy::WriteRotaries => {
            "write rotary words and let them unwind off the part (--unwind with -d heidenhain-axes, siemens-axes, fanuc \
             or linuxcnc), or divide the cut by a rapid move before this line"
        }
        PostRemedy::ToolLengths => {
            "give the length of each tool, --tool-length NUMBER=L; or post one tool: --tool NUMBER"
        }
        PostRemedy::ToolLength => {
            "give its length: --tool-length NUMBER=L, and --from-tool-length where it differs"
        }
        PostRemedy::GiveOrigin => {
            "enter the work offset at the control, and give the origin with --from-origin"
        }
        PostRemedy::InspectInput => {
            "`trunnion inspect` lists the contents of the file; with --tool, check which tools it calls"
        }
        PostRemedy::Advice(advice) => advice,
        _ => "",
    }
}
