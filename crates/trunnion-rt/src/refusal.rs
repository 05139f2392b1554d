//! Reasons for a refusal as numbers, with their texts.

use trunnion::inverse::PoseRefusal;
use trunnion::machine::TravelExcess;

/// Number of a reason; 0 is no refusal. Numbers keep their meaning in later versions.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(i32)]
pub enum RefusalCode {
    /// Nothing is refused.
    None = 0,
    /// An axis would leave its travel.
    OutOfTravel = 1,
    /// The rotaries cannot turn the tool into this direction.
    Unreachable = 2,
    /// The linear axes lie in one plane with the rotaries where they are.
    FlatSlides = 3,
    /// A number is NaN or infinite.
    NotFinite = 4,
    /// The tool length changed with the tool tilted: the linear axes would have to jump.
    LengthChanged = 5,
    /// The control asked for a kind of kinematics that does not exist.
    UnknownMode = 6,
    /// A fault inside the library, or a null pointer from its caller.
    Internal = 7,
    /// A block moves a letter for which the machine has no axis.
    NoAxis = 8,
}

impl RefusalCode {
    /// Returns the code with a number; `None` for a number without a meaning.
    pub fn from_number(number: i32) -> Option<Self> {
        let all = [
            Self::None,
            Self::OutOfTravel,
            Self::Unreachable,
            Self::FlatSlides,
            Self::NotFinite,
            Self::LengthChanged,
            Self::UnknownMode,
            Self::Internal,
            Self::NoAxis,
        ];
        all.into_iter().find(|code| *code as i32 == number)
    }

    /// Returns the text of a code, with the remedy.
    pub fn text(self) -> &'static str {
        // The texts end with a zero byte for C.
        self.c_text().strip_suffix('\0').unwrap_or_default()
    }

    /// Returns the text with a zero byte at its end.
    pub(crate) fn c_text(self) -> &'static str {
        match self {
            Self::None => "nothing is refused\0",
            Self::OutOfTravel => {
                "an axis would leave its travel; move the workpiece, or turn the rotaries another way\0"
            }
            Self::Unreachable => {
                "the rotaries cannot turn the tool into this direction; turn the workpiece\0"
            }
            Self::FlatSlides => {
                "the linear axes lie in one plane with the rotaries here; turn a rotary away from this position\0"
            }
            Self::NotFinite => {
                "a position or the tool length is not a finite number; check the HAL pins\0"
            }
            Self::LengthChanged => {
                "the tool length changed with the tool tilted; switch tool-centre-point control off before G43 or G49\0"
            }
            Self::UnknownMode => {
                "there are two kinds of kinematics: 0 is plain axes, 1 is tool-centre-point control\0"
            }
            Self::Internal => {
                "a fault inside trunnion; please report it with the machine file and the program\0"
            }
            Self::NoAxis => {
                "the machine file has no axis for this letter; take the letter out of the program\0"
            }
        }
    }
}

/// Refusal of a position.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
#[error("{}", code.text())]
pub struct Refusal {
    /// Reason.
    pub code: RefusalCode,
    /// Axis that is outside its travel, as an index into the joints.
    pub axis: Option<usize>,
    /// Distance outside: of the axis \[mm or rad\], or of the tool direction \[rad\]; 0 where nothing is measured.
    pub excess: f64,
}

impl Refusal {
    /// Creates a refusal that no axis is to blame for.
    pub const fn new(code: RefusalCode) -> Self {
        Self { code, axis: None, excess: 0.0 }
    }
}

impl From<TravelExcess> for Refusal {
    fn from(excess: TravelExcess) -> Self {
        Self { code: RefusalCode::OutOfTravel, axis: Some(excess.index), excess: excess.excess }
    }
}

impl From<PoseRefusal> for Refusal {
    fn from(refusal: PoseRefusal) -> Self {
        match refusal {
            PoseRefusal::Unreachable { miss, .. } => {
                Self { excess: miss, ..Self::new(RefusalCode::Unreachable) }
            }
            PoseRefusal::OutOfTravel(excess) => excess.into(),
            PoseRefusal::FlatSlides { .. } => Self::new(RefusalCode::FlatSlides),
            PoseRefusal::NotFinite { .. } => Self::new(RefusalCode::NotFinite),
            // A reason that the kinematics know and this version does not.
            _ => Self::new(RefusalCode::Internal),
        }
    }
}
