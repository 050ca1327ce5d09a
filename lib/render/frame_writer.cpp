// FrameWriter: encoders and writers behind the renderer.
//
// Frames get tickets in the order of write().  Workers take them from a queue in that order, encode side by
// side, and, where the frames share a file, wait for their turn to write.  The worker with the lowest
// ticket never waits for another, so the line always moves.
#include <algorithm>
#include <condition_variable>
#include <cstring>
#include <deque>
#include <exception>
#include <map>
#include <mutex>
#include <thread>

#include "core/error.h"
#include "core/file.h"
#include "core/parallel.h"
#include "render/image.h"
#include "render/png_reader.h"
#include "render/y4m.h"

namespace render {
namespace {

using core::Error;
using core::text;
using core::UsageError;

// One file that holds several frames, one after the other.
struct Stream {
    explicit Stream(const std::string& path) : file(path) {}
    core::OutputFile file;
    uint64_t next_turn = 0;    // of the next frame to be written
    uint64_t frame_count = 0;  // handed out so far
};

// What a worker does: encode, then write to a file of its own or to the stream in its turn.
struct Job {
    enum class Kind { picture, depth } kind = Kind::picture;
    int width = 0, height = 0;
    int channels = 3;            // of a picture's pixels
    std::vector<uint8_t> bytes;  // the pixels, or the depths as they lie in memory
    std::string path;            // file of its own
    Stream* stream = nullptr;    // or the shared one
    uint64_t turn = 0;           // in the stream
};

void put_rgba(const Frame& frame, std::vector<uint8_t>& out) {
    out.resize(4 * frame.alpha.size());
    for (size_t i = 0; i < frame.alpha.size(); ++i) {
        std::memcpy(out.data() + 4 * i, frame.rgb.data() + 3 * i, 3);
        out[4 * i + 3] = frame.alpha[i];
    }
}

}  // namespace

struct FrameWriter::State {
    std::string name;
    ImageFormat format;
    double frames_per_s;
    bool is_sequence;

    int stream_width = 0, stream_height = 0;
    std::map<std::string, std::unique_ptr<Stream>> streams;  // by name

    std::mutex mutex;
    std::condition_variable changed;
    std::deque<Job> queue;
    std::vector<std::vector<uint8_t>> spare;  // buffers of finished jobs
    size_t in_flight = 0;                     // queued or with a worker
    size_t depth_limit = 0;
    std::exception_ptr failure;
    bool closing = false;
    std::vector<std::jthread> workers;

    void start();
    void stop();
    void throw_failure();
    std::vector<uint8_t> take_buffer();
    void submit(Job job);
    Stream& stream_of(const std::string& path);
    void place(Job& job, const std::string& path, int frame_number, const std::string& eye);
    void work();
    void run(Job& job);
    std::vector<std::byte> encode(const Job& job) const;
    void write_in_turn(const Job& job, const std::vector<std::byte>& data);
    void end_job(Job& job);
};

void FrameWriter::State::start() {
    // More encoders than this outrun any renderer, and each has a file under construction.
    constexpr int kMostWorkers = 16;
    const size_t count = static_cast<size_t>(std::clamp(core::thread_count(), 1, kMostWorkers));
    depth_limit = count + 2;  // one for each worker, one being filled, one to fall back on
    for (size_t i = 0; i < count; ++i) workers.emplace_back([this] { work(); });
}

// Lets the workers finish what is queued, or drop it after a failure, and joins them.
void FrameWriter::State::stop() {
    {
        const std::lock_guard lock(mutex);
        closing = true;
    }
    changed.notify_all();
    workers.clear();
}

void FrameWriter::State::throw_failure() {
    const std::lock_guard lock(mutex);
    if (failure) std::rethrow_exception(failure);
}

std::vector<uint8_t> FrameWriter::State::take_buffer() {
    if (workers.empty()) start();
    std::unique_lock lock(mutex);
    changed.wait(lock, [this] { return in_flight < depth_limit || failure; });
    if (failure) std::rethrow_exception(failure);
    if (spare.empty()) return {};
    std::vector<uint8_t> buffer = std::move(spare.back());
    spare.pop_back();
    return buffer;
}

void FrameWriter::State::submit(Job job) {
    {
        const std::lock_guard lock(mutex);
        queue.push_back(std::move(job));
        ++in_flight;
    }
    changed.notify_all();
}

Stream& FrameWriter::State::stream_of(const std::string& path) {
    std::unique_ptr<Stream>& stream = streams[path];
    if (!stream) stream = std::make_unique<Stream>(path);
    return *stream;
}

void FrameWriter::State::place(Job& job, const std::string& path, int frame_number, const std::string& eye) {
    if (has_frame_number(path)) {
        job.path = frame_name(path, frame_number, eye);
        return;
    }
    const std::string file = frame_name(path, frame_number, eye);
    Stream& stream = stream_of(file);
    // A viewer would show the first of several pictures in one file and be silent about the others.
    const bool holds_one = job.kind == Job::Kind::depth || format == ImageFormat::png;
    if (holds_one && stream.frame_count > 0 && file != "-")
        throw Error(text("%s: a second frame for one picture file; number the files with %%04d in the name",
                         file.c_str()));
    job.stream = &stream;
    job.turn = stream.frame_count++;
}

void FrameWriter::State::work() {
    for (;;) {
        Job job;
        {
            std::unique_lock lock(mutex);
            changed.wait(lock, [this] { return !queue.empty() || closing; });
            if (queue.empty()) return;
            job = std::move(queue.front());
            queue.pop_front();
        }
        try {
            run(job);
        } catch (...) {
            const std::lock_guard lock(mutex);
            if (!failure) failure = std::current_exception();
        }
        end_job(job);
    }
}

void FrameWriter::State::run(Job& job) {
    {
        const std::lock_guard lock(mutex);
        if (failure) return;
    }
    const std::vector<std::byte> data = encode(job);
    if (job.stream) return write_in_turn(job, data);
    core::OutputFile file(job.path);
    file.write(data);
    file.commit();
}

std::vector<std::byte> FrameWriter::State::encode(const Job& job) const {
    const uint8_t* rgb = job.bytes.data();
    if (job.kind == Job::Kind::depth)
        return encode_pfm(reinterpret_cast<const float*>(rgb), job.width, job.height);
    switch (format) {
        case ImageFormat::png:
            return encode_png(rgb, job.width, job.height, job.channels);
        case ImageFormat::ppm:
            return encode_ppm(rgb, job.width, job.height);
        case ImageFormat::rgb: {
            const auto* bytes = reinterpret_cast<const std::byte*>(rgb);
            return {bytes, bytes + job.bytes.size()};
        }
        case ImageFormat::y4m:
            break;
    }
    // A file of its own, as the first frame of a stream, begins with the stream's header.
    std::string header = job.turn == 0 ? y4m_header(job.width, job.height, frames_per_s) : "";
    header += "FRAME\n";
    std::vector<std::byte> out(header.size() + yuv420_size(job.width, job.height));
    std::memcpy(out.data(), header.data(), header.size());
    rgb_to_yuv420(rgb, job.width, job.height, reinterpret_cast<uint8_t*>(out.data() + header.size()));
    return out;
}

void FrameWriter::State::write_in_turn(const Job& job, const std::vector<std::byte>& data) {
    std::unique_lock lock(mutex);
    changed.wait(lock, [&] { return job.stream->next_turn == job.turn || failure; });
    if (failure) return;
    lock.unlock();  // the turn is the right to write: nobody else touches the file before end_job()
    job.stream->file.write(data);
}

void FrameWriter::State::end_job(Job& job) {
    {
        const std::lock_guard lock(mutex);
        // After a failure turns may end out of order; then nobody writes any more.
        if (job.stream && job.stream->next_turn == job.turn) ++job.stream->next_turn;
        spare.push_back(std::move(job.bytes));
        --in_flight;
    }
    changed.notify_all();
}

FrameWriter::FrameWriter(std::string name, ImageFormat format, double frames_per_s)
    : state_(std::make_unique<State>()) {
    if (!(frames_per_s > 0 && frames_per_s <= 1000))
        throw UsageError(text("%g frames a second; the rate must be above 0 and at most 1000", frames_per_s));
    state_->is_sequence = has_frame_number(name);
    state_->name = std::move(name);
    state_->format = format;
    state_->frames_per_s = frames_per_s;
}

FrameWriter::~FrameWriter() {
    {
        const std::lock_guard lock(state_->mutex);
        state_->in_flight -= state_->queue.size();
        state_->queue.clear();
    }
    state_->stop();
}

void FrameWriter::write(int frame_number, const Frame& frame, const std::string& eye) {
    State& s = *state_;
    check_image_size(frame.width, frame.height, s.name);
    if (!s.is_sequence && s.stream_width != 0 &&
        (s.stream_width != frame.width || s.stream_height != frame.height))
        throw Error(text("%s: frame %d is %d x %d pixels, the stream began with %d x %d", s.name.c_str(),
                         frame_number, frame.width, frame.height, s.stream_width, s.stream_height));
    s.stream_width = frame.width, s.stream_height = frame.height;
    if (!frame.alpha.empty() && s.format != ImageFormat::png)
        throw Error(
            text("%s: frame %d is transparent, which only PNG can hold", s.name.c_str(), frame_number));
    Job job;
    job.width = frame.width, job.height = frame.height;
    job.bytes = s.take_buffer();
    if (frame.alpha.empty()) {
        job.bytes.assign(frame.rgb.begin(), frame.rgb.end());
    } else {
        job.channels = 4;
        put_rgba(frame, job.bytes);
    }
    s.place(job, s.name, frame_number, eye);
    s.submit(std::move(job));
}

void FrameWriter::write_depth(const std::string& name, int frame_number, const Frame& frame,
                              const std::string& eye) {
    State& s = *state_;
    if (name == s.name) throw UsageError(text("'%s': pictures and depths go to one file", name.c_str()));
    check_image_size(frame.width, frame.height, name);
    Job job;
    job.kind = Job::Kind::depth;
    job.width = frame.width, job.height = frame.height;
    job.bytes = s.take_buffer();
    const auto* depth = reinterpret_cast<const uint8_t*>(frame.depth.data());
    job.bytes.assign(depth, depth + frame.depth.size() * sizeof(float));
    s.place(job, name, frame_number, eye);
    s.submit(std::move(job));
}

void FrameWriter::finish() {
    State& s = *state_;
    s.stop();
    s.throw_failure();
    for (auto& [name, stream] : s.streams) stream->file.commit();
    s.streams.clear();
}

}  // namespace render
