//! The base of all crates of Meliora, which knows no model: errors with places, text, files, exact
//! numbers, progress, and decision diagrams as plain data. It uses no other crate of Meliora.
//!
//! - [`error::Error`], [`error::Diagnostic`] and [`error::SourceFile`]: errors with places.
//! - [`progress::ProgressSink`]: progress and cancellation.
//! - [`exact::Exact`], [`real::Real`] and [`value::Value`]: values and their arithmetic.
//! - [`interval::Interval`] and [`number::Number`]: numbers of solvers, rounded outwards or exact;
//!   [`bound::Bound`]: a bound of a certificate.
//! - [`diagram::Diagram`]: shared, reduced decision diagrams.
//! - [`escape`], [`csv`], [`json`]: text for each target; [`files`]: files that appear whole or not at all.
//!
//! ```
//! use meliora_base::error::{Diagnostic, SourceFile};
//!
//! let source = SourceFile::new("grid.prism", "x = 3 &\ntrue + 1");
//! let wrong = Diagnostic::new(&source, 8..12, "`+` adds numbers").label("a Boolean");
//! assert_eq!(wrong.position(), (2, 1));
//! ```

pub mod bound;
pub mod csv;
pub mod decimal;
mod diagnostic;
pub mod diagram;
pub mod error;
pub mod escape;
pub mod exact;
pub mod files;
pub mod interval;
pub mod json;
pub mod members;
pub mod memory;
mod named;
pub mod number;
pub mod progress;
pub mod random;
mod ratio;
pub mod reading;
pub mod real;
pub mod rounding;
pub mod short;
pub mod slip;
pub mod span;
pub mod stack;
pub mod sync;
pub mod value;
