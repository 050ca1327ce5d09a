#include "qs-view/overlay.h"

#include <backends/imgui_impl_opengl3.h>
#include <imgui.h>

#include <cmath>

#include "core/error.h"
#include "view/status.h"

namespace qs_view {

namespace {

constexpr float kFontPx = 13;  // that the built-in font is made for
constexpr ImGuiWindowFlags kPlain = ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_AlwaysAutoResize |
                                    ImGuiWindowFlags_NoInputs | ImGuiWindowFlags_NoSavedSettings |
                                    ImGuiWindowFlags_NoFocusOnAppearing | ImGuiWindowFlags_NoNav;

void begin(const char* name, const ImVec2& at, const ImVec2& pivot) {
    ImGui::SetNextWindowPos(at, ImGuiCond_Always, pivot);
    ImGui::SetNextWindowBgAlpha(0.6f);
    ImGui::Begin(name, nullptr, kPlain);
}

void draw_bar(const char* name, double part) {
    ImGui::TextUnformatted(name);
    ImGui::SameLine();
    ImGui::ProgressBar(float(part), ImVec2(10 * ImGui::GetFontSize(), 0));
}

void draw_status(const OverlayContent& content, const ImVec2& size) {
    const bool has_bars = content.refinement < 1 || content.download < 1;
    if (content.status.empty() && content.note.empty() && !has_bars && !content.is_recording) return;
    begin("status", ImVec2(0, size.y), ImVec2(0, 1));
    ImGui::PushTextWrapPos(size.x - 2 * ImGui::GetStyle().WindowPadding.x);
    if (content.is_recording) ImGui::TextColored(ImVec4(1, 0.4f, 0.3f, 1), "recording");
    if (!content.note.empty()) ImGui::TextUnformatted(content.note.c_str());
    if (content.refinement < 1) draw_bar("refining  ", content.refinement);
    if (content.download == 0) ImGui::TextUnformatted("fetching ...");
    if (content.download > 0 && content.download < 1) draw_bar("fetching  ", content.download);
    if (!content.status.empty()) ImGui::TextUnformatted(content.status.c_str());
    ImGui::PopTextWrapPos();
    ImGui::End();
}

void draw_legend(const std::vector<view::LegendEntry>& legend, const ImVec2& size) {
    begin("legend", ImVec2(size.x, 0), ImVec2(1, 0));  // the status line may need all of the bottom
    ImGui::TextUnformatted("drawn so wide");
    const float side = ImGui::GetFontSize();
    for (const view::LegendEntry& entry : legend) {
        const ImVec2 at = ImGui::GetCursorScreenPos();
        ImGui::GetWindowDrawList()->AddRectFilled(
            at, ImVec2(at.x + side, at.y + side),
            IM_COL32(entry.colour.r, entry.colour.g, entry.colour.b, 255));
        ImGui::Dummy(ImVec2(side, side));
        ImGui::SameLine();
        ImGui::TextUnformatted(entry.text.c_str());
    }
    ImGui::End();
}

void draw_keys() {
    begin("keys", ImVec2(0, 0), ImVec2(0, 0));
    if (ImGui::BeginTable("keys", 2, ImGuiTableFlags_SizingFixedFit)) {
        for (const view::KeyHelp& help : view::key_help()) {
            ImGui::TableNextColumn();
            ImGui::TextUnformatted(help.keys);
            ImGui::TableNextColumn();
            ImGui::TextUnformatted(help.meaning);
        }
        ImGui::EndTable();
    }
    ImGui::End();
}

void draw_message(const std::string& message, const ImVec2& size) {
    ImGui::SetNextWindowSizeConstraints(ImVec2(0, 0), ImVec2(0.9f * size.x, size.y));
    begin("message", ImVec2(0.5f * size.x, 0.5f * size.y), ImVec2(0.5f, 0.5f));
    ImGui::PushTextWrapPos(0.8f * size.x);
    ImGui::TextUnformatted(message.c_str());
    ImGui::PopTextWrapPos();
    ImGui::End();
}

}  // namespace

Overlay::Overlay(double scale) {
    IMGUI_CHECKVERSION();
    ImGui::CreateContext();
    ImGuiIO& io = ImGui::GetIO();
    io.IniFilename = nullptr;  // nothing is kept
    io.LogFilename = nullptr;
    ImFontConfig font;
    font.SizePixels = std::round(kFontPx * float(scale));
    io.Fonts->AddFontDefault(&font);
    ImGui::StyleColorsDark();
    ImGui::GetStyle().ScaleAllSizes(float(scale));
    ImGui::GetStyle().WindowBorderSize = 0;
    if (!ImGui_ImplOpenGL3_Init("#version 330 core"))
        throw core::Error("OpenGL: the overlay's shaders cannot be made");
}

Overlay::~Overlay() {
    ImGui_ImplOpenGL3_Shutdown();
    ImGui::DestroyContext();
}

void Overlay::draw(const OverlayContent& content, const glm::ivec2& size_px) {
    const ImVec2 size(float(size_px.x), float(size_px.y));
    ImGui::GetIO().DisplaySize = size;
    ImGui_ImplOpenGL3_NewFrame();
    ImGui::NewFrame();
    draw_status(content, size);
    if (!content.legend.empty()) draw_legend(content.legend, size);
    if (content.has_keys) draw_keys();
    if (!content.message.empty()) draw_message(content.message, size);
    ImGui::Render();
    ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
}

}  // namespace qs_view
