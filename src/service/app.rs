//! The whole application: all routes, the gate before them, and the state that they share.

use std::sync::{Arc, OnceLock};
use std::time::Duration;

use axum::Router;
use axum::http::{HeaderName, HeaderValue, Method, header};
use axum::middleware::from_fn_with_state;
use axum::routing::get;
use tower_http::cors::CorsLayer;
use utoipa::openapi::OpenApi;

use super::error::ApiError;
use super::gate::{GateLayer, admission};
use super::handlers::{docs, page};
use super::openapi::DOCUMENTS;
use super::ownership::{IDEMPOTENCY_KEY, OWNER};
use super::request_id::REQUEST_ID;
use super::routes::routes;
use super::state::AppState;

/// All routes with their state, ready to be served.
#[derive(Clone)]
pub struct Service {
    pub(super) router: Router,
    pub(super) app: Arc<AppState>,
}

/// Returns all routes of the service.
pub fn router(app: AppState) -> Service {
    static ROUTES: OnceLock<Router<Arc<AppState>>> = OnceLock::new();
    behind_gate(ROUTES.get_or_init(all_routes).clone(), app)
}

/// Returns all routes. This takes milliseconds, because it also describes them.
fn all_routes() -> Router<Arc<AppState>> {
    let (routes, _) = routes(OpenApi::default(), DOCUMENTS).split_for_parts();
    routes
        .route("/", get(page::home))
        .route("/dashboard/{file}", get(page::file))
        .route("/docs", get(docs::home))
        .route("/docs/", get(docs::page))
        .route("/docs/{file}", get(docs::file))
}

/// Puts the gate before the routes, and answers unknown routes and methods with problems.
fn behind_gate(routes: Router<Arc<AppState>>, app: AppState) -> Service {
    let app = Arc::new(app);
    let router = routes
        .fallback(|uri: axum::http::Uri| async move {
            ApiError::not_found(format!("there is no route {}; see /openapi.json", uri.path()))
        })
        .method_not_allowed_fallback(|| async { ApiError::method_not_allowed() });
    let gate = |admits| GateLayer { app: Arc::clone(&app), admits };
    let origins = &app.config.allowed_origins;
    let router = if origins.is_empty() {
        router.layer(gate(true))
    } else {
        let admission = from_fn_with_state(Arc::clone(&app), admission);
        router.layer(admission).layer(cors(origins)).layer(gate(false))
    };
    Service { router: router.with_state(Arc::clone(&app)), app }
}

/// Lets pages of these origins read answers.
fn cors(origins: &[String]) -> CorsLayer {
    let origins: Vec<HeaderValue> = origins.iter().filter_map(|origin| origin.parse().ok()).collect();
    let request_headers: [HeaderName; 6] =
        [header::CONTENT_TYPE, header::AUTHORIZATION, header::ACCEPT, REQUEST_ID, OWNER, IDEMPOTENCY_KEY];
    CorsLayer::new()
        .allow_origin(origins)
        .allow_methods([Method::GET, Method::POST, Method::PUT, Method::DELETE])
        .allow_headers(request_headers)
        .expose_headers([header::LOCATION, header::RETRY_AFTER, REQUEST_ID])
        .max_age(Duration::from_hours(1))
}

#[cfg(test)]
mod tests {
    use std::io::{Read as _, Write as _};
    use std::net::{SocketAddr, TcpStream};
    use std::sync::Mutex;
    use std::sync::atomic::{AtomicU32, Ordering};
    use std::time::Instant;

    use axum::body::Bytes;
    use axum::extract::Path;
    use axum::routing::post;

    use super::*;
    use crate::service::handlers::operation;
    use crate::service::{Robots, RunningServer, ServiceConfig, Supervisor, bind, serve_supervised};

    /// Returns status and body of an answer.
    fn get_text(url: &str) -> (u16, String) {
        let agent: ureq::Agent = ureq::Agent::config_builder().http_status_as_error(false).build().into();
        let mut response = agent.get(url).header("x-request-id", "mine-1").call().unwrap();
        (response.status().as_u16(), response.body_mut().read_to_string().unwrap())
    }

    /// Starts a service with these routes alone.
    fn start(routes: Router<Arc<AppState>>) -> RunningServer {
        RunningServer::start(behind_gate(routes, AppState::new(Robots::built_in()))).unwrap()
    }

    #[test]
    fn connections_take_turns_after_each_answer() {
        let order: Arc<Mutex<Vec<String>>> = Arc::default();
        let called = Arc::clone(&order);
        // The first call keeps the thread until the requests of both connections have arrived.
        let call = move |Path(name): Path<String>, _: Bytes| async move {
            let mut called = called.lock().unwrap();
            if called.is_empty() {
                std::thread::sleep(Duration::from_millis(500));
            }
            called.push(name);
        };
        let server = start(Router::new().route("/call/{name}", post(call)));
        let connect = || TcpStream::connect(server.url().trim_start_matches("http://")).unwrap();
        let mut streams = [connect(), connect()];
        for (stream, name) in streams.iter_mut().zip(["a", "b"]) {
            // Together the requests are larger than the buffers.
            let head = format!("POST /call/{name} HTTP/1.1\r\nhost: localhost\r\ncontent-length: 900\r\n");
            let body = "x".repeat(900);
            let requests = format!("{head}\r\n{body}").repeat(300) + &format!("{head}connection: close\r\n\r\n{body}");
            stream.write_all(requests.as_bytes()).unwrap();
        }
        for stream in &mut streams {
            stream.read_to_string(&mut String::new()).unwrap();
        }
        let order = order.lock().unwrap().concat();
        let (first, last) = (order.find('b').unwrap(), order.rfind('a').unwrap());
        let both = &order[first..last];
        // A request that arrives alone needs no turn, so a connection may have two or three in a row.
        assert!(both.len() > 400 && !both.contains("aaaaa") && !both.contains("bbbbb"), "{order}");
    }

    #[test]
    fn a_panic_is_answered_as_a_problem_with_the_request_id_and_counted() {
        async fn panics() -> &'static str {
            panic!("meant for a test")
        }
        let routes = Router::new().route("/panic", get(panics)).route("/metrics", get(operation::metrics));
        let server = start(routes);
        let (status, body) = get_text(&(server.url() + "/panic"));
        let problem: serde_json::Value = serde_json::from_str(&body).unwrap();
        assert_eq!((status, &problem["type"]), (500, &"/problems/internal".into()));
        assert_eq!(problem["request_id"], "mine-1");
        assert!(!body.contains("meant for a test"), "{body}");
        let (_, metrics) = get_text(&(server.url() + "/metrics"));
        for line in ["revprio_panics_total 1", r#"revprio_requests_total{route="/panic",status="500"} 1"#] {
            assert!(metrics.contains(line), "{line} is not in {metrics}");
        }
    }

    /// A stream that opens during the shutdown keeps its connection.
    #[tokio::test]
    async fn an_announced_shutdown_closes_connections_after_their_answer() {
        use axum::http::{Request, StatusCode};
        let routes = Router::new()
            .route("/answer", get(|| async { StatusCode::OK }))
            .route("/stream", get(|| async { StatusCode::SWITCHING_PROTOCOLS }));
        let mut service = behind_gate(routes, AppState::new(Robots::built_in()));
        let mut closes = async |path: &str| {
            let request = Request::get(path).header(header::HOST, "localhost").body(axum::body::Body::empty()).unwrap();
            let answer = tower_service::Service::call(&mut service.router, request).await.unwrap();
            answer.headers().get(header::CONNECTION).is_some_and(|value| value == "close")
        };
        assert!(!closes("/answer").await && !closes("/stream").await);
        service.app.drain.announce();
        assert!(closes("/answer").await && !closes("/stream").await);
    }

    /// Counts the reports of the watching thread.
    #[derive(Default)]
    struct Reports {
        ready: AtomicU32,
        alive: AtomicU32,
        stuck: AtomicU32,
        stopping: AtomicU32,
    }

    impl Supervisor for Arc<Reports> {
        fn ready(&self) {
            self.ready.fetch_add(1, Ordering::Relaxed);
        }

        fn alive(&self) {
            self.alive.fetch_add(1, Ordering::Relaxed);
        }

        fn stuck(&self) {
            self.stuck.fetch_add(1, Ordering::Relaxed);
        }

        fn stopping(&self) {
            self.stopping.fetch_add(1, Ordering::Relaxed);
        }
    }

    /// Returns the answer of a probe on a connection of its own; `None` if there is none within two seconds.
    fn probe(address: SocketAddr) -> Option<String> {
        let mut stream = TcpStream::connect(address).ok()?;
        stream.set_read_timeout(Some(Duration::from_secs(2))).ok()?;
        stream.write_all(b"GET /healthz HTTP/1.1\r\nhost: localhost\r\nconnection: close\r\n\r\n").ok()?;
        let mut answer = String::new();
        stream.read_to_string(&mut answer).ok()?;
        Some(answer)
    }

    /// Probes until the answer begins with this text.
    fn await_probe(address: SocketAddr, start: &str) -> String {
        let deadline = Instant::now() + Duration::from_secs(20);
        loop {
            let answer = probe(address).unwrap_or_default();
            if answer.starts_with(start) {
                return answer;
            }
            assert!(Instant::now() < deadline, "not {start}: {answer}");
        }
    }

    #[test]
    fn a_stuck_service_says_so_and_is_reported() {
        // Keeps the thread of the requests until the test releases it.
        let (release, released) = std::sync::mpsc::channel::<()>();
        let released = Arc::new(Mutex::new(released));
        let hold = move || async move {
            let _ = released.lock().unwrap().recv();
        };
        let routes = Router::new().route("/hold", get(hold)).route("/healthz", get(operation::alive));
        let config = ServiceConfig { stuck_after: Duration::from_secs(1), ..ServiceConfig::default() };
        let service = behind_gate(routes, AppState::with_config(Robots::built_in(), config));
        let listener = bind(SocketAddr::from(([127, 0, 0, 1], 0))).unwrap();
        let address = listener.local_addr().unwrap();
        let (stop, stopped) = tokio::sync::oneshot::channel::<()>();
        let reports = Arc::new(Reports::default());
        let supervisor = Arc::clone(&reports);
        let thread = std::thread::spawn(move || {
            serve_supervised(listener, service, async { drop(stopped.await) }, supervisor).unwrap();
        });
        await_probe(address, "HTTP/1.1 200 ");
        let mut holder = TcpStream::connect(address).unwrap();
        holder.write_all(b"GET /hold HTTP/1.1\r\nhost: localhost\r\n\r\n").unwrap();
        let answer = await_probe(address, "HTTP/1.1 503 ");
        assert!(answer.contains("/problems/stuck"), "{answer}");
        let deadline = Instant::now() + Duration::from_secs(20);
        while reports.stuck.load(Ordering::Relaxed) == 0 && Instant::now() < deadline {
            std::thread::sleep(Duration::from_millis(10));
        }
        release.send(()).unwrap();
        await_probe(address, "HTTP/1.1 200 ");
        drop(stop);
        thread.join().unwrap();
        let count = |counter: &AtomicU32| counter.load(Ordering::Relaxed);
        assert_eq!((count(&reports.ready), count(&reports.stopping)), (1, 1));
        assert!(count(&reports.alive) > 0 && count(&reports.stuck) > 0);
        assert!(TcpStream::connect(address).is_err(), "the watching thread still listens");
    }
}
