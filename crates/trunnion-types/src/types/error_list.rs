//! Lists of errors that are an error themselves.

use std::error::Error;
use std::fmt;
use std::ops::Deref;

/// All errors that a check found, as one [`Error`].
///
/// Checks report everything that is wrong at once, not only the first error. The list dereferences to a
/// slice, and is displayed one error a line.
///
/// # Example
///
/// ```
/// use trunnion_types::types::{Diagnostic, Diagnostics};
///
/// fn read(text: &str) -> Result<f64, Diagnostics> {
///     let wrong = |error| vec![Diagnostic::at(text, 0, format!("`{text}`: {error}"))];
///     Ok(text.parse().map_err(wrong)?)
/// }
///
/// fn twice(text: &str) -> Result<f64, Box<dyn std::error::Error>> {
///     Ok(2.0 * read(text)?)
/// }
///
/// assert_eq!(twice("1.5")?, 3.0);
/// assert_eq!(twice("one").unwrap_err().to_string(), "1:1: `one`: invalid float literal");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ErrorList<E>(Vec<E>);

impl<E> ErrorList<E> {
    /// Creates an empty list.
    pub const fn new() -> Self {
        Self(Vec::new())
    }

    /// Appends an error.
    pub fn push(&mut self, error: E) {
        self.0.push(error);
    }

    /// Returns `value` if the list is empty, and the list as the error otherwise.
    ///
    /// # Errors
    ///
    /// The list itself, if it holds an error.
    pub fn into_result<T>(self, value: T) -> Result<T, Self> {
        if self.0.is_empty() { Ok(value) } else { Err(self) }
    }
}

impl<E> Default for ErrorList<E> {
    fn default() -> Self {
        Self::new()
    }
}

impl<E> Deref for ErrorList<E> {
    type Target = [E];

    fn deref(&self) -> &[E] {
        &self.0
    }
}

impl<E: PartialEq, const N: usize> PartialEq<[E; N]> for ErrorList<E> {
    fn eq(&self, other: &[E; N]) -> bool {
        self.0 == other
    }
}

impl<E> From<Vec<E>> for ErrorList<E> {
    fn from(errors: Vec<E>) -> Self {
        Self(errors)
    }
}

impl<E> From<E> for ErrorList<E> {
    fn from(error: E) -> Self {
        Self(vec![error])
    }
}

impl<E> From<ErrorList<E>> for Vec<E> {
    fn from(errors: ErrorList<E>) -> Self {
        errors.0
    }
}

impl<E> FromIterator<E> for ErrorList<E> {
    fn from_iter<I: IntoIterator<Item = E>>(errors: I) -> Self {
        Self(errors.into_iter().collect())
    }
}

impl<E> Extend<E> for ErrorList<E> {
    fn extend<I: IntoIterator<Item = E>>(&mut self, errors: I) {
        self.0.extend(errors);
    }
}

impl<E> IntoIterator for ErrorList<E> {
    type Item = E;
    type IntoIter = std::vec::IntoIter<E>;

    fn into_iter(self) -> Self::IntoIter {
        self.0.into_iter()
    }
}

impl<'a, E> IntoIterator for &'a ErrorList<E> {
    type Item = &'a E;
    type IntoIter = std::slice::Iter<'a, E>;

    fn into_iter(self) -> Self::IntoIter {
        self.0.iter()
    }
}

impl<E: fmt::Display> fmt::Display for ErrorList<E> {
    /// Writes one error a line.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, error) in self.0.iter().enumerate() {
            if index > 0 {
                f.write_str("\n")?;
            }
            error.fmt(f)?;
        }
        Ok(())
    }
}

impl<E: fmt::Debug + fmt::Display> Error for ErrorList<E> {}
