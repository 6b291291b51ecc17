//! The server as a browser, a stranger and an attacker meet it.
#![expect(
    clippy::disallowed_methods,
    clippy::unwrap_used,
    reason = "tests measure the time that answers take"
)]

use std::io::{Read as _, Write as _};
use std::net::{SocketAddr, TcpStream};
use std::os::unix::fs::PermissionsExt;
use std::sync::Arc;
use std::time::{Duration, Instant};

use backseat_console::{
    About, Act, Asked, Feed, Hub, Item, Kind, Limits, Listener, Origin, Pace, Service, Teller, Tls, Token, serve,
};
use backseat_units::Timestamp;
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use serde_json::Value;
use tempfile::TempDir;
use tokio::sync::mpsc::Receiver;
use tungstenite::{Message, connect};

struct Console {
    address: SocketAddr,
    hub: Hub,
    feed: Feed,
    asked: Receiver<Asked>,
    token: String,
    _folder: TempDir,
}

fn console() -> Console {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("console.token");
    let token = Token::create(&path).unwrap();
    let origin = Origin { lat: 42.0, lon: -70.0 };
    let about = About {
        operator: true,
        ..About::new(
            Kind::Live,
            "isobath",
            7,
            origin,
            "[[plugin]]\nname = \"isobath\"\n",
            "{}",
        )
    };
    let hub = Hub::new(&about, Limits::LIVE);
    let feed = hub.listen(Teller::new(about.budgets())).unwrap();
    let listener = Listener::open("127.0.0.1:0".parse().unwrap()).unwrap();
    let address = listener.address();
    let service = Service {
        hub: hub.clone(),
        token: Some(token),
        live: true,
        pace: None,
    };
    Console {
        address,
        hub,
        feed,
        asked: serve(listener, service).unwrap(),
        token: std::fs::read_to_string(&path).unwrap().trim().to_owned(),
        _folder: folder,
    }
}

impl Console {
    /// Sends a request as it is, and returns the whole answer.
    fn raw(&self, request: &str) -> String {
        let mut stream = TcpStream::connect(self.address).unwrap();
        stream.set_read_timeout(Some(Duration::from_secs(20))).unwrap();
        stream.write_all(request.as_bytes()).unwrap();
        let mut answer = Vec::new();
        // A server that cuts the connection off has answered too.
        drop(stream.read_to_end(&mut answer));
        String::from_utf8_lossy(&answer).into_owned()
    }

    fn get(&self, path: &str) -> String {
        self.raw(&format!(
            "GET {path} HTTP/1.1\r\nHost: {}\r\nConnection: close\r\n\r\n",
            self.address
        ))
    }

    fn post(&self, token: &str, body: &str, more: &str) -> String {
        self.raw(&format!(
            "POST /api/operator HTTP/1.1\r\nHost: {}\r\nConnection: close\r\nContent-Type: application/json\r\n\
             Authorization: Bearer {token}\r\nContent-Length: {}\r\n{more}\r\n{body}",
            self.address,
            body.len()
        ))
    }
}

fn status(answer: &str) -> u16 {
    let code = answer.split(' ').nth(1).and_then(|code| code.parse().ok());
    code.unwrap_or_else(|| panic!("no answer: {answer:?}"))
}

const HOLD: &str = r#"{"act":"hold","who":"Ann"}"#;

#[test]
fn a_browser_gets_the_page_and_what_happened() {
    let console = console();
    let page = console.get("/");
    assert!(page.contains("text/html") && page.contains("<html"), "{page}");
    assert!(page.contains("content-security-policy: default-src 'self'"), "{page}");
    for file in [
        "/assets/js/main.js",
        "/assets/style.css",
        "/assets/vendor/leaflet/leaflet.js",
    ] {
        assert_eq!(status(&console.get(file)), 200, "{file}");
    }
    let about = console.get("/api/about");
    let about: Value = serde_json::from_str(about.split("\r\n\r\n").nth(1).unwrap()).unwrap();
    assert_eq!(
        (&about["kind"], &about["plugins"][0]["name"]),
        (&"live".into(), &"isobath".into())
    );
    assert_eq!(about["run"].as_str().map(str::len), Some(16));
    for t in 0..1000 {
        let text = format!("line {t}");
        let item = Item::Status { text };
        console.hub.add(f64::from(t), &item, t % 2 == 0);
    }
    let history = console.get("/api/history");
    assert_eq!(history.matches(r#""kind":"status""#).count(), 500);
    assert!(
        history.contains(r#"{"n":1,"t":0.0,"kind":"status","text":"line 0"}"#),
        "{history}"
    );
}

#[test]
fn the_feed_goes_on_where_a_browser_was_and_tells_it_to_begin_again_if_that_is_gone() {
    let console = console();
    let mut told = 0;
    let mut tell = |count: u64| {
        for _ in 0..count {
            told += 1;
            let now = Timestamp::ZERO + Duration::from_millis(told);
            let message = format!(r#"{{"granted":true,"reason":"{told}"}}"#);
            console.feed.tell(now, "/control", message.as_bytes());
        }
    };
    tell(3);
    let socket = |after: u64| {
        connect(format!("ws://{}/api/feed?after={after}", console.address))
            .unwrap()
            .0
    };
    let items = |message: Message| -> Vec<Value> { serde_json::from_str(message.to_text().unwrap()).unwrap() };
    let mut browser = socket(0);
    let mut seen = Vec::new();
    while seen.len() < 4 {
        seen.extend(items(browser.read().unwrap()));
    }
    // The first message makes a beat too.
    assert_eq!(
        seen.iter().filter(|item| item["kind"] == "control").count(),
        3,
        "{seen:?}"
    );
    let last = seen.last().unwrap()["n"].as_u64().unwrap();
    // Nothing happens: an empty frame says that the program lives.
    assert_eq!(items(browser.read().unwrap()), Vec::<Value>::new());
    drop(browser);
    tell(1);
    let after = loop {
        let found = items(socket(last).read().unwrap());
        if let Some(first) = found.first() {
            break first["n"].as_u64();
        }
    };
    assert_eq!(after, Some(last + 1));
    let reset = items(socket(1_000_000).read().unwrap());
    assert_eq!(reset[0]["kind"], "reset", "a number of another run");
    for t in 0..20_000 {
        let text = "more than is kept for those who are late".to_owned();
        console.hub.add(f64::from(t), &Item::Status { text }, true);
    }
    let reset = items(socket(last).read().unwrap());
    assert_eq!(reset[0]["kind"], "reset", "too late");
}

#[test]
fn only_who_has_the_token_holds_and_wrong_ones_are_slowed_and_told() {
    let mut console = console();
    assert_eq!(status(&console.post(&console.token, HOLD, "")), 202);
    let asked = console.asked.try_recv().unwrap();
    assert_eq!((asked.act, asked.who.as_str()), (Act::Hold, "Ann"));
    for (body, code) in [
        (r#"{"act":"hold"}"#, 400),
        (r#"{"act":"hold","who":""}"#, 400),
        (r#"{"act":"hold","who":"a\nb"}"#, 400),
        (r#"{"act":"abort","who":"Ann"}"#, 400),
        ("[]", 400),
        ("not JSON", 400),
    ] {
        let answer = console.post(&console.token, body, "");
        assert_eq!(status(&answer), code, "{body}");
        assert!(
            answer.contains("expected {") || answer.contains("who: expected"),
            "{answer}"
        );
    }
    // Whoever gives no token learns how, at once, and has not guessed.
    let began = Instant::now();
    let without = console.raw(&format!(
        "POST /api/operator HTTP/1.1\r\nHost: {}\r\nConnection: close\r\nContent-Length: {}\r\n\r\n{HOLD}",
        console.address,
        HOLD.len()
    ));
    assert_eq!(status(&without), 401);
    assert!(without.contains("Authorization: Bearer TOKEN") && began.elapsed() < Duration::from_millis(900));
    let began = Instant::now();
    let wrong = "0".repeat(32);
    assert_eq!(status(&console.post(&wrong, HOLD, "")), 401);
    assert!(began.elapsed() > Duration::from_millis(900), "the answer is slowed");
    for token in ["0", &console.token[1..], &format!("{}0", console.token), ""] {
        assert_eq!(status(&console.post(token, HOLD, "")), 401);
    }
    assert!(
        console
            .get("/api/history")
            .contains("5 wrong tokens so far, the last from 127.0.0.1"),
        "people see it"
    );
    assert!(console.asked.try_recv().is_err());
    let began = Instant::now();
    assert_eq!(status(&console.post(&console.token, HOLD, "")), 202);
    assert!(
        began.elapsed() < Duration::from_millis(900),
        "the right one does not wait"
    );
    assert!(console.asked.try_recv().is_ok());
}

#[test]
fn other_sites_and_other_names_get_nothing() {
    let console = console();
    let port = console.address.port();
    for (host, more, code) in [
        (format!("127.0.0.1:{port}"), "Origin: http://evil.example\r\n", 403),
        ("evil.example".to_owned(), "", 403),
        (format!("localhost:{port}"), "", 200),
    ] {
        let answer = console.raw(&format!(
            "GET /api/about HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\n{more}\r\n"
        ));
        assert_eq!(status(&answer), code, "{host} {more}");
    }
    assert_eq!(
        status(&console.post(&console.token, HOLD, "Origin: http://evil.example\r\n")),
        403
    );
    for path in [
        "/../../../etc/passwd",
        "/assets/../Cargo.toml",
        "/assets/..%2f..%2fCargo.toml",
        "/assets//etc/passwd",
        "/api/none",
    ] {
        assert_eq!(status(&console.get(path)), 404, "{path}");
    }
}

#[test]
fn large_bodies_long_heads_and_sockets_that_say_nothing_cost_little() {
    let console = console();
    let large = console.raw(&format!(
        "POST /api/operator HTTP/1.1\r\nHost: {}\r\nConnection: close\r\nContent-Type: application/json\r\n\
         Authorization: Bearer {}\r\nContent-Length: 1000000000\r\n\r\n{{\"act\"",
        console.address, console.token
    ));
    assert_eq!(status(&large), 413);
    let began = Instant::now();
    let slow = console.raw(&format!(
        "POST /api/operator HTTP/1.1\r\nHost: {}\r\nConnection: close\r\nContent-Type: application/json\r\n\
         Authorization: Bearer {}\r\nContent-Length: 100\r\n\r\n{{\"act\"",
        console.address, console.token
    ));
    assert!(
        status(&slow) == 408 && began.elapsed() < Duration::from_secs(10),
        "{slow}"
    );
    let long = console.raw(&format!(
        "GET /api/about HTTP/1.1\r\nHost: {}\r\nX-Long: {}\r\n\r\n",
        console.address,
        "x".repeat(1 << 20)
    ));
    assert!(long.is_empty() || matches!(status(&long), 400 | 431), "{long}");
    // Sockets that say nothing, refilled as fast as they are closed, keep nobody out.
    let over = std::sync::atomic::AtomicBool::new(false);
    std::thread::scope(|scope| {
        for _ in 0..2 {
            scope.spawn(|| {
                let mut idle = std::collections::VecDeque::new();
                while !over.load(std::sync::atomic::Ordering::Relaxed) {
                    idle.extend(TcpStream::connect(console.address));
                    if idle.len() > 100 {
                        idle.pop_front();
                    }
                    std::thread::sleep(Duration::from_millis(1));
                }
            });
        }
        std::thread::sleep(Duration::from_millis(500));
        let answered = (0..20)
            .filter(|_| console.get("/api/about").starts_with("HTTP/1.1 200"))
            .count();
        over.store(true, std::sync::atomic::Ordering::Relaxed);
        assert!(answered >= 12, "{answered} of 20 were answered");
    });
}

/// Holds five times while others ask for what never ends: requests whose body does not come, and wrong tokens, whose answer
/// is slowed. There are more of them than connections, and each that is closed is renewed.
#[test]
fn sr_015_nobody_without_the_token_keeps_out_who_has_it() {
    let mut console = console();
    let never_ends = |authorization: &str, length: usize| {
        format!(
            "POST /api/operator HTTP/1.1\r\nHost: {}\r\nContent-Type: application/json\r\n{authorization}Content-Length: \
             {length}\r\n\r\n{{",
            console.address
        )
    };
    let asks = [
        never_ends("", 50),
        never_ends("Authorization: Bearer 0123\r\n", 50),
        never_ends("Authorization: Bearer 0123\r\n", 1).replace("/api/operator", "/api/pace"),
    ];
    let over = std::sync::atomic::AtomicBool::new(false);
    let answers = std::thread::scope(|scope| {
        for ask in &asks {
            let (over, address) = (&over, console.address);
            scope.spawn(move || {
                let mut open = std::collections::VecDeque::new();
                while !over.load(std::sync::atomic::Ordering::Relaxed) {
                    let asked = TcpStream::connect(address)
                        .and_then(|mut stream| stream.write_all(ask.as_bytes()).map(|()| stream));
                    open.extend(asked);
                    if open.len() > 130 {
                        open.pop_front();
                    }
                    std::thread::sleep(Duration::from_millis(2));
                }
            });
        }
        std::thread::sleep(Duration::from_millis(600));
        let answers: Vec<_> = (0..5)
            .map(|_| {
                let began = Instant::now();
                let answer = console.post(&console.token, HOLD, "");
                (
                    answer.split("\r\n").next().unwrap_or_default().to_owned(),
                    began.elapsed(),
                )
            })
            .collect();
        over.store(true, std::sync::atomic::Ordering::Relaxed);
        answers
    });
    for (answer, took) in &answers {
        assert!(
            answer.contains(" 202 ") && *took < Duration::from_secs(2),
            "{answers:?}"
        );
    }
    assert!((0..5).all(|_| console.asked.try_recv().is_ok()));
}

#[test]
fn a_hold_is_never_too_soon_and_a_second_release_is() {
    let mut console = console();
    const RELEASE: &str = r#"{"act":"release","who":"Ann"}"#;
    let told: Vec<u16> = [RELEASE, HOLD, RELEASE, HOLD]
        .iter()
        .map(|body| status(&console.post(&console.token, body, "")))
        .collect();
    assert_eq!(told, [202, 202, 429, 202]);
    let acts: Vec<Act> = std::iter::from_fn(|| console.asked.try_recv().ok())
        .map(|asked| asked.act)
        .collect();
    assert_eq!(acts, [Act::Release, Act::Hold, Act::Hold]);
    // More than wait for the run are told so: it has not ended.
    let answers: Vec<String> = (0..20).map(|_| console.post(&console.token, HOLD, "")).collect();
    let full = answers.iter().find(|answer| status(answer) != 202).unwrap();
    assert!(status(full) == 503 && full.contains("16 acts wait"), "{full}");
}

#[test]
fn feeds_are_bounded_and_the_oldest_makes_room() {
    let console = console();
    let mut feeds: Vec<_> = (0..50)
        .map(|_| connect(format!("ws://{}/api/feed?after=0", console.address)).unwrap().0)
        .collect();
    let mut newest = feeds.pop().unwrap();
    assert!(newest.read().unwrap().is_text());
    let open = feeds
        .iter_mut()
        .map(|feed| (0..3).all(|_| feed.read().is_ok()))
        .collect::<Vec<bool>>();
    assert_eq!(open.iter().filter(|is| **is).count(), 31, "{open:?}");
    assert!(open[18..].iter().all(|is| *is), "{open:?}");
    // The operator is still answered.
    assert_eq!(status(&console.post(&console.token, HOLD, "")), 202);
}

#[test]
fn a_log_that_was_read_has_no_feed_and_nothing_to_hold() {
    let origin = Origin { lat: 42.0, lon: -70.0 };
    let about = About::new(Kind::Recorded, "isobath", 7, origin, "", "{}");
    let hub = Hub::new(&about, Limits::RECORDED);
    let listener = Listener::open("127.0.0.1:0".parse().unwrap()).unwrap();
    let address = listener.address();
    let service = Service {
        hub: hub.clone(),
        token: None,
        live: false,
        pace: None,
    };
    let asked = serve(listener, service).unwrap();
    let feed = connect(format!("ws://{address}/api/feed?after=0"));
    assert!(feed.is_err());
    let mut stream = TcpStream::connect(address).unwrap();
    let request = format!(
        "POST /api/operator HTTP/1.1\r\nHost: {address}\r\nConnection: close\r\nContent-Type: application/json\r\n\
         Content-Length: {}\r\n\r\n{HOLD}",
        HOLD.len()
    );
    stream.write_all(request.as_bytes()).unwrap();
    let mut answer = String::new();
    stream.read_to_string(&mut answer).unwrap();
    assert_eq!(status(&answer), 409, "{answer}");
    drop(asked);
}

#[test]
fn the_console_is_for_this_computer_alone_and_says_when_its_port_is_taken() {
    let error = Listener::open("0.0.0.0:8480".parse().unwrap()).unwrap_err().to_string();
    assert!(
        error.contains("on this computer alone") && error.contains("ssh -L"),
        "{error}"
    );
    let first = Listener::open("127.0.0.1:0".parse().unwrap()).unwrap();
    let error = Listener::open(first.address()).unwrap_err().to_string();
    assert!(error.contains("give another port") && !error.contains('\n'), "{error}");
}

#[test]
fn the_pace_of_a_simulation_can_be_set_and_that_of_nothing_else() {
    let ask = |address: SocketAddr, body: &str| {
        let mut stream = TcpStream::connect(address).unwrap();
        let request = format!(
            "POST /api/pace HTTP/1.1\r\nHost: {address}\r\nConnection: close\r\nContent-Type: application/json\r\n\
             Content-Length: {}\r\n\r\n{body}",
            body.len()
        );
        stream.write_all(request.as_bytes()).unwrap();
        let mut answer = String::new();
        stream.read_to_string(&mut answer).unwrap();
        status(&answer)
    };
    assert_eq!(ask(console().address, "{\"times\": 2}"), 409);
    let origin = Origin { lat: 42.0, lon: -70.0 };
    let hub = Hub::new(
        &About::new(Kind::Simulated, "isobath", 7, origin, "", "{}"),
        Limits::LIVE,
    );
    let listener = Listener::open("127.0.0.1:0".parse().unwrap()).unwrap();
    let address = listener.address();
    let pace = Pace::new(Some(20.0));
    let service = Service {
        hub,
        token: None,
        live: true,
        pace: Some(pace.clone()),
    };
    let _asked = serve(listener, service).unwrap();
    for wrong in [
        "{\"times\": -1}",
        "{\"times\": null}",
        "{}",
        "{\"times\": 1, \"more\": 2}",
        "no JSON",
    ] {
        assert!((400..=422).contains(&ask(address, wrong)), "{wrong}");
    }
    assert_eq!(pace.times(), 20.0);
    assert_eq!(ask(address, "{\"times\": 0}"), 202);
    assert_eq!(pace.times(), 0.0);
    let mut stream = TcpStream::connect(address).unwrap();
    write!(
        stream,
        "GET /api/about HTTP/1.1\r\nHost: {address}\r\nConnection: close\r\n\r\n"
    )
    .unwrap();
    let mut about = String::new();
    stream.read_to_string(&mut about).unwrap();
    assert!(about.contains("\"pace\":{\"times\":0.0}"), "{about}");
}

/// A console that other computers reach, on loopback here.
struct Open {
    address: SocketAddr,
    token: String,
    client: Arc<rustls::ClientConfig>,
    folder: TempDir,
    _asked: Receiver<Asked>,
}

fn open_console() -> Open {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let made = rcgen::generate_simple_self_signed(["vehicle.example".to_owned()]).unwrap();
    std::fs::write(at("cert.pem"), made.cert.pem()).unwrap();
    std::fs::write(at("key.pem"), made.signing_key.serialize_pem()).unwrap();
    std::fs::set_permissions(at("key.pem"), PermissionsExt::from_mode(0o600)).unwrap();
    let token = Token::create(&at("console.token")).unwrap();
    let origin = Origin { lat: 42.0, lon: -70.0 };
    let about = About {
        operator: true,
        ..About::new(Kind::Live, "isobath", 7, origin, "", "{}")
    };
    let tls = Tls::read(&at("cert.pem"), &at("key.pem")).unwrap();
    let listener = Listener::open_to_all("127.0.0.1:0".parse().unwrap(), tls).unwrap();
    let address = listener.address();
    assert_eq!(listener.url(), format!("https://{address}"));
    let service = Service {
        hub: Hub::new(&about, Limits::LIVE),
        token: Some(token),
        live: true,
        pace: None,
    };
    let asked = serve(listener, service).unwrap();
    let mut roots = rustls::RootCertStore::empty();
    roots.add(made.cert.der().clone()).unwrap();
    let provider = Arc::new(rustls::crypto::ring::default_provider());
    let client = rustls::ClientConfig::builder_with_provider(provider)
        .with_safe_default_protocol_versions()
        .unwrap()
        .with_root_certificates(roots)
        .with_no_client_auth();
    Open {
        address,
        token: std::fs::read_to_string(at("console.token")).unwrap().trim().to_owned(),
        client: Arc::new(client),
        folder,
        _asked: asked,
    }
}

impl Open {
    fn connect(&self) -> rustls::StreamOwned<rustls::ClientConnection, TcpStream> {
        let name = "vehicle.example".to_owned().try_into().unwrap();
        let connection = rustls::ClientConnection::new(Arc::clone(&self.client), name).unwrap();
        let stream = TcpStream::connect(self.address).unwrap();
        stream.set_read_timeout(Some(Duration::from_secs(20))).unwrap();
        rustls::StreamOwned::new(connection, stream)
    }

    fn raw(&self, request: &str) -> String {
        let mut stream = self.connect();
        stream.write_all(request.as_bytes()).unwrap();
        let mut answer = Vec::new();
        drop(stream.read_to_end(&mut answer));
        String::from_utf8_lossy(&answer).into_owned()
    }

    fn get(&self, path: &str, more: &str) -> String {
        self.raw(&format!(
            "GET {path} HTTP/1.1\r\nHost: vehicle.example:8480\r\nConnection: close\r\n{more}\r\n"
        ))
    }

    fn basic(&self, password: &str) -> String {
        format!(
            "Authorization: Basic {}\r\n",
            STANDARD.encode(format!("ann:{password}"))
        )
    }
}

#[test]
fn a_console_that_others_reach_answers_only_through_tls_and_with_the_token() {
    let console = open_console();
    let unknown = console.get("/api/about", "");
    assert_eq!(status(&unknown), 401);
    assert!(
        unknown.to_ascii_lowercase().contains("www-authenticate: basic"),
        "{unknown}"
    );
    assert!(
        unknown.to_ascii_lowercase().contains("x-frame-options: deny"),
        "{unknown}"
    );
    for path in ["/", "/metrics", "/api/history", "/api/feed", "/assets/style.css"] {
        assert_eq!(status(&console.get(path, "")), 401, "{path}");
    }
    let begun = Instant::now();
    assert_eq!(status(&console.get("/", &console.basic("wrong"))), 401);
    assert!(begun.elapsed() >= Duration::from_millis(900), "a wrong token is slowed");
    let known = console.basic(&console.token);
    let page = console.get("/", &known);
    assert_eq!(status(&page), 200);
    assert!(page.contains("wss://vehicle.example:8480"), "{page}");
    assert!(console.get("/api/about", &known).contains("\"mission\":\"isobath\""));
    let bearer = format!("Authorization: Bearer {}\r\n", console.token);
    assert_eq!(status(&console.get("/metrics", &bearer)), 200);
    // The page of another site, in a browser that knows the token.
    let elsewhere = format!("{known}Origin: https://evil.example\r\n");
    assert_eq!(status(&console.get("/api/about", &elsewhere)), 403);
    // The page's own request, which has the token that was typed into it.
    let post = |token: &str| {
        console.raw(&format!(
            "POST /api/operator HTTP/1.1\r\nHost: vehicle.example\r\nOrigin: https://vehicle.example\r\n\
             Connection: close\r\nAuthorization: Bearer {token}\r\nContent-Type: application/json\r\n\
             Content-Length: {}\r\n\r\n{HOLD}",
            HOLD.len()
        ))
    };
    let refused = post("wrong");
    assert_eq!(status(&refused), 401);
    assert!(!refused.to_ascii_lowercase().contains("www-authenticate"), "{refused}");
    assert_eq!(status(&post(&console.token)), 202);
    // Without TLS nothing is answered.
    let mut plain = TcpStream::connect(console.address).unwrap();
    plain.set_read_timeout(Some(Duration::from_secs(20))).unwrap();
    write!(plain, "GET /api/about HTTP/1.1\r\nHost: localhost\r\n{known}\r\n").unwrap();
    let mut answer = Vec::new();
    drop(plain.read_to_end(&mut answer));
    assert!(!String::from_utf8_lossy(&answer).contains("HTTP/1.1"), "{answer:?}");
}

#[test]
fn the_feed_goes_through_tls() {
    let console = open_console();
    let request = |known: &str| {
        let request = tungstenite::http::Request::builder()
            .uri("wss://vehicle.example/api/feed?after=0")
            .header("Host", "vehicle.example")
            .header("Connection", "Upgrade")
            .header("Upgrade", "websocket")
            .header("Sec-WebSocket-Version", "13")
            .header("Sec-WebSocket-Key", "dGhlIHNhbXBsZSBub25jZQ==");
        if known.is_empty() {
            request
        } else {
            request.header("Authorization", known)
        }
        .body(())
        .unwrap()
    };
    assert!(tungstenite::client(request(""), console.connect()).is_err());
    let known = console.basic(&console.token);
    let known = known.trim().strip_prefix("Authorization: ").unwrap().to_owned();
    let (mut feed, _) = tungstenite::client(request(&known), console.connect()).unwrap();
    assert!(matches!(feed.read(), Ok(Message::Text(_))));
}

#[test]
fn a_certificate_or_key_that_cannot_be_used_is_told() {
    let console = open_console();
    let at = |name: &str| console.folder.path().join(name);
    let refused = |certificate: &str, key: &str| Tls::read(&at(certificate), &at(key)).unwrap_err().to_string();
    assert!(refused("none.pem", "key.pem").contains("none.pem: "));
    std::fs::write(at("empty.pem"), "").unwrap();
    assert!(refused("empty.pem", "key.pem").contains("empty.pem: no certificate in PEM"));
    assert!(refused("cert.pem", "cert.pem").contains("cert.pem: no private key in PEM"));
    // The two in each other's place.
    assert!(refused("key.pem", "cert.pem").contains("key.pem: no certificate in PEM: is this the key?"));
    let other = rcgen::generate_simple_self_signed(["other.example".to_owned()]).unwrap();
    std::fs::write(at("other.pem"), other.signing_key.serialize_pem()).unwrap();
    std::fs::set_permissions(at("other.pem"), PermissionsExt::from_mode(0o644)).unwrap();
    assert!(refused("cert.pem", "other.pem").contains("other.pem: mode 644 lets others read the key: chmod 600"));
    std::fs::set_permissions(at("other.pem"), PermissionsExt::from_mode(0o600)).unwrap();
    let text = refused("cert.pem", "other.pem");
    assert!(
        text.contains("other.pem: cannot be used with") && text.contains("cert.pem"),
        "{text}"
    );
}
