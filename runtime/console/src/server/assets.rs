use axum::http::header::{CACHE_CONTROL, CONTENT_TYPE};
use axum::http::{StatusCode, Uri};
use axum::response::{IntoResponse as _, Response};
use rust_embed::RustEmbed;

/// The page's files, inside the program.
#[derive(RustEmbed)]
#[folder = "assets/"]
struct Assets;

/// A file of the page. Only files that are in the program have names, so no path leads anywhere else.
pub(super) async fn file(uri: Uri) -> Response {
    let path = match uri.path() {
        "/" => "index.html",
        path => path.trim_start_matches('/').trim_start_matches("assets/"),
    };
    let Some(file) = Assets::get(path) else {
        return (StatusCode::NOT_FOUND, "not found\n").into_response();
    };
    let kind = match path.rsplit_once('.').map(|(_, extension)| extension) {
        Some("html") => "text/html; charset=utf-8",
        Some("js" | "mjs") => "text/javascript; charset=utf-8",
        Some("css") => "text/css; charset=utf-8",
        Some("svg") => "image/svg+xml",
        Some("png") => "image/png",
        Some("json") => "application/json",
        Some(_) | None => "text/plain; charset=utf-8",
    };
    // The files change with the program, and are near.
    ([(CONTENT_TYPE, kind), (CACHE_CONTROL, "no-cache")], file.data).into_response()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_time_of_the_computer_that_compiled_it_is_in_the_program() {
        let files: Vec<_> = Assets::iter().collect();
        assert!(files.len() > 10, "{files:?}");
        for name in files {
            let about = Assets::get(&name).unwrap().metadata;
            // Zero, or none where the embedding says so.
            assert_eq!(
                (about.last_modified().unwrap_or(0), about.created().unwrap_or(0)),
                (0, 0),
                "{name}"
            );
        }
    }
}
