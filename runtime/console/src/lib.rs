//! The web console: a page that shows what the vehicle, the runtime and each plugin do, and why.
//!
//! The console reads what a log has: messages of its channels, live as they are recorded, or from a file. A [`Teller`]
//! turns them into [`Item`]s, which say what happened in the words of the page. A [`Hub`] numbers and keeps them within
//! bounds. [`serve`] gives the page and the items to browsers.
//!
//! Nothing here waits for a browser, and the loop waits for nothing here: [`Feed::tell`] never blocks, and what finds no
//! room is left out, counted and told. A browser that is slow or away is told to begin again.

mod about;
mod feed;
mod history;
mod hub;
mod item;
mod metrics;
mod operator;
mod pace;
mod server;
mod teller;
mod token;

pub use about::{About, Kind, Member, Origin};
pub use feed::{Feed, Told, wants};
pub use history::Limits;
pub use hub::Hub;
pub use item::Item;
pub use operator::{Act, Asked};
pub use pace::Pace;
pub use server::{Listener, ServerError, Service, Tls, serve};
pub use teller::Teller;
pub use token::Token;
