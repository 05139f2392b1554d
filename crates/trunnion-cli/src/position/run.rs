//! The verb: places the cutter, draws and prints.

use super::answer::{Answer, table};
use super::args::{PositionArgs, Side, Strip};
use super::compare;
use super::drawing::picture;
use super::inputs::{cutter, face, require_on_surface};
use super::refusal::{is_request_error, refusal, with_help};
use crate::form::OutputForm;
use crate::outcome::{Done, Failure};
use crate::output;
use trunnion::positioning::{ContactSide, LocationRequest, StripSide, ToleranceBand, place};

pub(crate) fn run(args: &PositionArgs, form: OutputForm) -> Result<Done, Failure> {
    if let Some(path) = &args.output {
        output::protect(path, &[&args.surface])?;
    }
    let face = face(args)?;
    require_on_surface(&face.face().surface, args.at)?;
    let cutter = cutter(args)?;
    let tolerance = args.tolerance;
    let band = ToleranceBand { lower: 0.0, upper: tolerance };
    let request = LocationRequest {
        strip: match args.strip {
            Strip::Right => StripSide::Right,
            Strip::Left => StripSide::Left,
        },
        side: match args.side {
            Side::Ahead => ContactSide::Ahead,
            Side::Behind => ContactSide::Behind,
            Side::Either => ContactSide::Either,
        },
        // Options are in degrees, the library in radians.
        offset_range: args.offset_range.map(f64::to_radians).into(),
        ..LocationRequest::new(&face, &cutter, band, args.at.into(), args.feed)
    };
    // A comparison treats refusals as results, a single placement as the end.
    if args.compare {
        return compare::run(&request, args, form);
    }
    let method = args.method.placing(args);
    match place(&request, &method) {
        Ok(location) => {
            if let Some(path) = &args.output {
                let picture =
                    picture(&request, &location, args).map_err(|error| refusal(&error))?;
                output::file(path, |out| out.write_all(picture.as_bytes()))?;
            }
            form.print(&Answer::new(&location, args.method), |_| table(&location, args))
        }
        // A wrong request is bad input (2); a point without a location is a result (1).
        Err(error) if is_request_error(&error) => Err(refusal(&error)),
        Err(error) => {
            let refused =
                serde_json::json!({ "refused": error.to_string(), "remedy": error.remedy() });
            form.print(&refused, |_| format!("no cutter location: {}\n", with_help(&error)))?;
            Ok(Done::Broken)
        }
    }
}
