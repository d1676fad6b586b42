//! What a report holds: `report.json`, and the data of what is shown beside it.

pub mod compare;
pub mod schema;
pub mod supplement;
