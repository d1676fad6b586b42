//! Process data of TRDP, as IEC 61375-2-3 describes it: telegrams in UDP datagrams to port 17224, each with a header that carries
//! a ComId and a sequence counter, and a data set whose layout an XML file describes.

mod sequence;
mod telegram;
mod xml;

pub use sequence::{Followed, Sequence};
pub use telegram::{HEADER_BYTES, LARGEST_DATA, Malformed, PORT, Telegram, parse, write};
pub use xml::read;
