//! Errors as HTTP answers.

use axum::response::{IntoResponse, Response};
use http::{HeaderValue, StatusCode, header};
use revprio_api::wire;

use super::{ApiError, kinds};

/// Media type of RFC 9457.
const PROBLEM_JSON: HeaderValue = HeaderValue::from_static("application/problem+json");

/// Returns the whole HTTP answer for a connection above the limit. The request of such a connection is never read.
pub fn connection_refusal() -> String {
    whole_answer(ApiError::new(&kinds::OVERLOADED, "too many connections are open; close some"))
}

/// Returns the whole HTTP answer for a connection that arrives while the thread of the requests is stuck.
pub fn stuck_refusal() -> String {
    whole_answer(ApiError::new(&kinds::STUCK, "the service is stuck; it ends itself if that continues"))
}

fn whole_answer(error: ApiError) -> String {
    let problem = error.into_wire();
    let body = serde_json::to_string(&problem).unwrap_or_default();
    let head = "HTTP/1.1 503 Service Unavailable\r\ncontent-type: application/problem+json\r\nretry-after: 1";
    format!("{head}\r\nconnection: close\r\ncontent-length: {}\r\n\r\n{body}", body.len())
}

impl ApiError {
    /// Writes the body of the answer, with the ID of the request.
    pub fn write(self, response: &mut Response, request_id: &str) {
        let body = wire::Problem { request_id: Some(request_id.to_owned()), ..self.into_wire() };
        // The inner layers set the length of the empty body.
        response.headers_mut().remove(header::CONTENT_LENGTH);
        *response.body_mut() = axum::Json(body).into_response().into_body();
    }
}

/// Writes status and headers. The gate writes the body, because only the gate knows the ID of the request.
impl IntoResponse for ApiError {
    fn into_response(self) -> Response {
        let mut response = self.kind.status.into_response();
        let headers = response.headers_mut();
        headers.insert(header::CONTENT_TYPE, PROBLEM_JSON);
        match self.kind.status {
            StatusCode::SERVICE_UNAVAILABLE | StatusCode::TOO_MANY_REQUESTS => {
                headers.insert(header::RETRY_AFTER, HeaderValue::from_static("1"))
            }
            StatusCode::UNAUTHORIZED => headers.insert(header::WWW_AUTHENTICATE, HeaderValue::from_static("Bearer")),
            StatusCode::UPGRADE_REQUIRED => headers.insert(header::UPGRADE, HeaderValue::from_static("websocket")),
            _ => None,
        };
        response.extensions_mut().insert(self);
        response
    }
}
