//! Diagrams in files: the XML interchange format BIF 0.3 (Cozman 1998), with the decisions and utilities that aGrUM and pyAgrum read and write.
//!
//! ```xml
//! <BIF VERSION="0.3">
//! <NETWORK>
//!   <NAME>bet</NAME>
//!   <VARIABLE TYPE="nature"><NAME>coin</NAME><OUTCOME>heads</OUTCOME><OUTCOME>tails</OUTCOME></VARIABLE>
//!   <VARIABLE TYPE="decision"><NAME>bet</NAME><OUTCOME>heads</OUTCOME><OUTCOME>tails</OUTCOME></VARIABLE>
//!   <VARIABLE TYPE="utility"><NAME>win</NAME><OUTCOME>0</OUTCOME></VARIABLE>
//!   <DEFINITION><FOR>coin</FOR><TABLE>0.6 0.4</TABLE></DEFINITION>
//!   <DEFINITION><FOR>win</FOR><GIVEN>coin</GIVEN><GIVEN>bet</GIVEN><TABLE>1 -1 -1 1</TABLE></DEFINITION>
//! </NETWORK>
//! </BIF>
//! ```
//!
//! * `GIVEN` names the parents in the order of the table, the first one slowest; the states of `FOR` are the fastest. For a decision it says what is seen, and there is no `TABLE`.
//! * `<PROPERTY>memory = limited</PROPERTY>` of the network is [`Memory::Limited`](crate::Memory::Limited). Others skip it. All other properties are skipped here.
//! * A row whose sum is off by up to [`ROUNDING`] was rounded when it was written; it is scaled to 1.
//! * What [`save`] writes, [`load`] reads as it was, to the last bit of every number.
//!
//! Loading takes any bytes and does not trust them: declarations of entities are refused, external files are never opened, and every refusal names line and column.

mod error;
mod load;
mod save;

pub use error::{LoadError, LoadFault, Problem};
pub use load::{ROUNDING, load};
pub use save::save;
