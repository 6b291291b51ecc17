//! A client of Foxglove's protocol, by what the protocol's page says, on a library that the server does not share its code
//! with.

#![expect(clippy::disallowed_methods, reason = "this is a client on a real socket")]
#![expect(
    clippy::unwrap_used,
    reason = "the lint exempts test functions only, not the functions that they call"
)]

use std::io::{Read as _, Write as _};
use std::net::{Ipv4Addr, SocketAddr, TcpListener, TcpStream};
use std::time::Duration;

use backseat_units::Timestamp;
use backseat_viewer::{Feed, Port, ViewerError, serve};
use serde_json::{Value, json};
use tungstenite::client::IntoClientRequest as _;
use tungstenite::{Message, WebSocket, client};

const BEGAN_NS: u64 = 1_790_000_000_000_000_000;
const ANY: SocketAddr = SocketAddr::new(std::net::IpAddr::V4(Ipv4Addr::LOCALHOST), 0);

struct Viewer {
    socket: WebSocket<TcpStream>,
}

impl Viewer {
    fn connected(address: SocketAddr) -> Self {
        let stream = TcpStream::connect(address).unwrap();
        stream.set_read_timeout(Some(Duration::from_secs(20))).unwrap();
        let mut request = format!("ws://{address}").into_client_request().unwrap();
        let protocol = "foxglove.sdk.v1".parse().unwrap();
        request.headers_mut().insert("Sec-WebSocket-Protocol", protocol);
        let (socket, _) = client(request, stream).unwrap();
        Self { socket }
    }

    fn next_json(&mut self) -> Value {
        loop {
            if let Message::Text(text) = self.socket.read().unwrap() {
                return serde_json::from_str(&text).unwrap();
            }
        }
    }

    /// The channels of the next advertisement.
    fn advertised(&mut self) -> Vec<Value> {
        loop {
            let message = self.next_json();
            if message["op"] == "advertise" {
                return message["channels"].as_array().unwrap().clone();
            }
        }
    }

    fn subscribe(&mut self, id: u32, channel: &Value) {
        let message = json!({"op": "subscribe", "subscriptions": [{"id": id, "channelId": channel}]});
        self.socket.send(Message::text(message.to_string())).unwrap();
    }

    /// The next message of a channel: subscription, time and payload.
    fn next_data(&mut self) -> (u32, u64, Value) {
        loop {
            let Message::Binary(bytes) = self.socket.read().unwrap() else {
                continue;
            };
            if bytes[0] != 1 {
                continue;
            }
            let id = u32::from_le_bytes(bytes[1..5].try_into().unwrap());
            let at_ns = u64::from_le_bytes(bytes[5..13].try_into().unwrap());
            return (id, at_ns, serde_json::from_slice(&bytes[13..]).unwrap());
        }
    }
}

fn served() -> (Feed, SocketAddr) {
    let port = Port::open(ANY).unwrap();
    let address = port.address();
    (serve(port, "dive", BEGAN_NS).unwrap(), address)
}

#[test]
fn a_viewer_sees_the_channels_of_the_log_with_their_schemas_and_times() {
    let (feed, address) = served();
    let at = Timestamp::from_secs(7);
    feed.tell(at, "/control", br#"{"text":"control granted","granted":true}"#);
    let mut viewer = Viewer::connected(address);
    let info = viewer.next_json();
    assert_eq!((&info["op"], &info["name"]), (&json!("serverInfo"), &json!("dive")));
    assert_eq!(info["capabilities"], json!([]), "viewers look, and do nothing");
    let channels = viewer.advertised();
    let control = channels.iter().find(|channel| channel["topic"] == "/control").unwrap();
    assert_eq!(control["encoding"], "json");
    assert_eq!(control["schemaName"], "backseat.Control");
    assert_eq!(control["schemaEncoding"], "jsonschema");
    let schema: Value = serde_json::from_str(control["schema"].as_str().unwrap()).unwrap();
    assert_eq!(schema["type"], "object");
    // What lasts is told to one who comes later.
    viewer.subscribe(5, &control["id"]);
    let (id, at_ns, value) = viewer.next_data();
    assert_eq!((id, at_ns), (5, BEGAN_NS + 7_000_000_000));
    assert_eq!(value["granted"], true);
    // A channel that begins later is advertised then.
    let later = Timestamp::from_millis(8500);
    feed.tell(
        later,
        "/notes",
        br#"{"text":"connected to the vehicle","note":"link-up"}"#,
    );
    let channels = viewer.advertised();
    assert_eq!(channels[0]["topic"], "/notes");
    viewer.subscribe(6, &channels[0]["id"]);
    // The subscription may arrive after a message that was told at once.
    for second in 9..40 {
        feed.tell(Timestamp::from_secs(second), "/notes", br#"{"text":"x","note":"text"}"#);
        std::thread::sleep(Duration::from_millis(20));
    }
    let (id, at_ns, value) = viewer.next_data();
    assert_eq!((id, value["text"].as_str()), (6, Some("x")));
    assert!(at_ns >= BEGAN_NS + 9_000_000_000, "{at_ns}");
}

/// The library advertises a channel before it notes that a client knows it. A client on the same computer is quicker now
/// and then, and its subscription was refused.
#[test]
fn a_viewer_that_subscribes_at_once_is_never_refused() {
    let (feed, address) = served();
    let mut viewers: Vec<Viewer> = (0..4).map(|_| Viewer::connected(address)).collect();
    for channel in 0..500 {
        feed.tell(Timestamp::ZERO, &format!("/measures/m{channel}"), br#"{"value":1}"#);
    }
    for viewer in &mut viewers {
        let mut subscribed = 0;
        while subscribed < 500 {
            let message = viewer.next_json();
            assert_ne!(message["op"], "status", "{message}");
            for channel in message["channels"].as_array().into_iter().flatten() {
                subscribed += 1;
                viewer.subscribe(subscribed, &channel["id"]);
            }
        }
        // All have arrived when the last one is refused.
        viewer.subscribe(999, &json!(999_999));
        let refused = viewer.next_json();
        assert_eq!(refused["message"], "Unknown channel ID: 999999");
    }
}

#[test]
fn viewers_that_take_nothing_or_send_nonsense_delay_nobody() {
    let (feed, address) = served();
    feed.tell(Timestamp::ZERO, "/control", br#"{"granted":false}"#);
    let mut stuck: Vec<Viewer> = (0..12).map(|_| Viewer::connected(address)).collect();
    for viewer in &mut stuck {
        let channels = viewer.advertised();
        viewer.subscribe(1, &channels[0]["id"]);
        viewer.socket.send(Message::text("{\"op\": \"nonsense\"")).unwrap();
        viewer.socket.send(Message::binary(vec![0; 100_000])).unwrap();
    }
    let silent: Vec<TcpStream> = (0..200).map(|_| TcpStream::connect(address).unwrap()).collect();
    let large = format!("{{\"text\":\"{}\"}}", "x".repeat(10_000));
    let begun = std::time::Instant::now();
    for second in 0..20_000 {
        feed.tell(Timestamp::from_secs(second), "/control", large.as_bytes());
    }
    // 200 MB for each of twelve viewers that read nothing.
    assert!(begun.elapsed() < Duration::from_secs(10), "{:?}", begun.elapsed());
    let mut good = Viewer::connected(address);
    let channels = good.advertised();
    good.subscribe(2, &channels[0]["id"]);
    assert_eq!(good.next_data().0, 2);
    drop(silent);
}

#[test]
fn viewers_are_bounded_and_the_oldest_makes_room() {
    let (feed, address) = served();
    feed.tell(Timestamp::ZERO, "/control", br#"{"granted":false}"#);
    let mut viewers: Vec<Viewer> = (0..40).map(|_| Viewer::connected(address)).collect();
    // The newest look, and the oldest are gone.
    let mut newest = viewers.pop().unwrap();
    let channels = newest.advertised();
    newest.subscribe(1, &channels[0]["id"]);
    assert_eq!(newest.next_data().0, 1);
    let open = viewers
        .iter_mut()
        .map(|viewer| {
            viewer
                .socket
                .get_mut()
                .set_read_timeout(Some(Duration::from_millis(50)))
                .unwrap();
            loop {
                match viewer.socket.read() {
                    Ok(_) => {}
                    Err(tungstenite::Error::Io(error)) if error.kind() == std::io::ErrorKind::WouldBlock => break true,
                    Err(_) => break false,
                }
            }
        })
        .collect::<Vec<bool>>();
    assert_eq!(open.iter().filter(|is| **is).count(), 15, "{open:?}");
    assert!(open[24..].iter().all(|is| *is), "{open:?}");
}

#[test]
fn a_browser_that_opens_the_address_reads_what_it_is_for() {
    let (_feed, address) = served();
    let mut stream = TcpStream::connect(address).unwrap();
    stream.set_read_timeout(Some(Duration::from_secs(20))).unwrap();
    stream
        .write_all(format!("GET / HTTP/1.1\r\nHost: {address}\r\n\r\n").as_bytes())
        .unwrap();
    let mut answer = String::new();
    stream.read_to_string(&mut answer).unwrap();
    assert!(
        answer.starts_with("HTTP/1.1 426 Upgrade Required\r\n") && answer.contains(&format!("ws://{address}")),
        "{answer}"
    );
}

#[test]
fn a_viewer_whose_message_is_too_large_is_cut_off_before_it_costs_memory() {
    let (feed, address) = served();
    let mut good = Viewer::connected(address);
    let mut bad = Viewer::connected(address);
    let stream = bad.socket.get_mut();
    // A text frame of 60 MB (RFC 6455, section 5.2), whose payload comes until nobody takes it.
    stream.write_all(&[0x81, 0xff]).unwrap();
    stream.write_all(&60_000_000u64.to_be_bytes()).unwrap();
    stream.write_all(&[0; 4]).unwrap();
    let mut sent = 0;
    while sent < 60_000_000 && stream.write_all(&[b' '; 64 << 10]).is_ok() {
        sent += 64 << 10;
    }
    assert!(sent < 20_000_000, "{sent} bytes were taken");
    // Everybody else goes on.
    feed.tell(Timestamp::from_secs(1), "/control", br#"{"text":"x","granted":true}"#);
    assert_eq!(good.advertised()[0]["topic"], "/control");
}

#[test]
fn it_listens_on_this_computer_alone_and_says_when_a_port_is_taken() {
    let open: SocketAddr = "0.0.0.0:0".parse().unwrap();
    let refused = Port::open(open).unwrap_err();
    assert!(matches!(refused, ViewerError::Address(_)), "{refused}");
    assert!(refused.to_string().contains("ssh -L"), "{refused}");
    let taken = TcpListener::bind(ANY).unwrap();
    let address = taken.local_addr().unwrap();
    let refused = Port::open(address).unwrap_err().to_string();
    assert!(
        refused.starts_with(&address.to_string()) && refused.contains("give another port"),
        "{refused}"
    );
}

#[test]
fn the_server_ends_with_its_run() {
    let (feed, address) = served();
    let mut viewer = Viewer::connected(address);
    drop(feed);
    while viewer.socket.read().is_ok() {}
    let gone = || TcpStream::connect(address).is_err();
    let mut tries = 0;
    while !gone() {
        tries += 1;
        assert!(tries < 500, "it still listens");
        std::thread::sleep(Duration::from_millis(20));
    }
}
