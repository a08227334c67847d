// Builds the scenes, one function for each name (Scene::Named()).
#pragma once

#include <memory>

namespace ulf::acquisition {

class Scene;

std::shared_ptr<const Scene> BuildStudio();
std::shared_ptr<const Scene> BuildEasel();
std::shared_ptr<const Scene> BuildWall();
std::shared_ptr<const Scene> BuildGloss();
std::shared_ptr<const Scene> BuildGlass();
std::shared_ptr<const Scene> BuildPlant();
std::shared_ptr<const Scene> BuildBust();
std::shared_ptr<const Scene> BuildRoom();
std::shared_ptr<const Scene> BuildPicture();
std::shared_ptr<const Scene> BuildBranch();
std::shared_ptr<const Scene> BuildLightbox();
std::shared_ptr<const Scene> BuildTurntable();

}  // namespace ulf::acquisition
